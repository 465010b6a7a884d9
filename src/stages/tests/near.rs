//! Triangles near pixels: squares against triangles by clipping, in f64.

use super::*;
use crate::stages::rasterize::Triangle;
use crate::stages::settle_near::{Plane, within};

/// The triangle cut to the square of half side `r` about p (Sutherland & Hodgman): corners as x, y and depth.
fn cut(corners: &[Vertex; 3], p: [f64; 2], r: f64) -> Vec<[f64; 3]> {
    let mut polygon: Vec<[f64; 3]> =
        corners.iter().map(|v| [f64::from(v.x), f64::from(v.y), f64::from(v.depth)]).collect();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let inside = |q: &[f64; 3]| r - sign * (q[axis] - p[axis]);
        let mut kept = Vec::new();
        for (k, a) in polygon.iter().enumerate() {
            let b = &polygon[(k + 1) % polygon.len()];
            let (da, db) = (inside(a), inside(b));
            if da >= 0.0 {
                kept.push(*a);
            }
            if (da < 0.0) != (db < 0.0) {
                kept.push(std::array::from_fn(|c| a[c] + (b[c] - a[c]) * da / (da - db)));
            }
        }
        polygon = kept;
    }
    polygon
}

#[test]
fn squares_that_meet_a_triangle_are_found_with_their_nearest_depth() {
    let mut random = Random(11);
    let (mut met, mut missed) = (0, 0);
    for _ in 0..4000 {
        let mut corners = [(); 3].map(|()| random.vertex(-4, 14));
        if random.below(4) == 0 {
            // Without an area, or a point.
            corners[2] = corners[random.below(2) as usize];
        }
        let reach = random.below(300) as i64;
        let t = Triangle::new(&corners);
        let plane = Plane::new(&t, reach);
        for y in 0..10i64 {
            let found = within(&t, reach, y, 0, 9);
            for x in 0..10i64 {
                let p = [x, y].map(|c| (c * 256 + 128) as f64);
                let near = cut(&corners, p, reach as f64);
                let ends = |k: usize| {
                    let values = corners.map(|v| f64::from(if k == 0 { v.x } else { v.y }));
                    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
                    low - reach as f64 <= p[k] && p[k] <= high + reach as f64
                };
                let told = ends(0) && ends(1) && found.is_some_and(|(from, to)| from <= x && x <= to);
                // Where they only touch, f64 may say anything.
                if cut(&corners, p, reach as f64 - 1e-6).is_empty() != cut(&corners, p, reach as f64 + 1e-6).is_empty()
                {
                    continue;
                }
                assert_eq!(told, !near.is_empty(), "{corners:?} {reach} at {x},{y}");
                let most = near.iter().map(|q| q[2]).fold(0.0, f64::max);
                assert!(near.is_empty() || plane.nearest(x, y) >= most - 1e-9, "{corners:?} {reach} at {x},{y}");
                if told { met += 1 } else { missed += 1 }
            }
        }
    }
    assert!(met > 10_000 && missed > 10_000, "{met} {missed}");
}
