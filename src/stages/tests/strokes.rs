//! Strokes: a pixel is drawn where the segment meets the square pen about its centre (research "crack-closing",
//! section 2, rules 2 to 4).

use super::*;
use crate::stages::topology::{depth_of, is_edge};

const SIZE: [u32; 2] = [28, 24];

/// The segment meets the closed square of half side `r` about p: the intervals of its parameter s in [0, 1] in which
/// each coordinate lies in the square have a common point. Fractions are compared by cross products.
fn meets(a: [i128; 2], b: [i128; 2], p: [i128; 2], r: i128) -> bool {
    // s in [low, high], as (numerator, positive denominator).
    let (mut low, mut high) = ((0, 1), (1, 1));
    let less = |a: (i128, i128), b: (i128, i128)| a.0 * b.1 < b.0 * a.1;
    for k in 0..2 {
        let d = b[k] - a[k];
        let (from, to) = (p[k] - r - a[k], p[k] + r - a[k]);
        if d == 0 {
            if from > 0 || to < 0 {
                return false;
            }
            continue;
        }
        let (enter, leave) = if d > 0 { ((from, d), (to, d)) } else { ((-to, -d), (-from, -d)) };
        low = if less(low, enter) { enter } else { low };
        high = if less(leave, high) { leave } else { high };
    }
    !less(high, low)
}

/// Not strictly on the triangle's side of the edge a-b.
fn is_outer([a, b, c]: [[i128; 2]; 3], p: [i128; 2]) -> bool {
    area(a, b, c).signum() * area(a, b, p).signum() <= 0
}

/// Rules 3 and 4 in f64.
fn depth([a, b, c]: &[Vertex; 3], p: [i128; 2], radius: i64) -> f64 {
    let at = |v: &Vertex| [f64::from(v.x) / 256.0, f64::from(v.y) / 256.0, f64::from(v.depth)];
    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (at(a), at(b), at(c));
    let (px, py) = (p[0] as f64 / 256.0 - ax, p[1] as f64 / 256.0 - ay);
    let (dx, dy) = (bx - ax, by - ay);
    let length2 = dx * dx + dy * dy;
    let s = if length2 == 0.0 { 0.0 } else { ((dx * px + dy * py) / length2).clamp(0.0, 1.0) };
    let range = az.max(bz).max(cz) - az.min(bz).min(cz);
    let area = dx * (cy - ay) - dy * (cx - ax);
    let push = if area == 0.0 {
        range
    } else {
        let slope_x = ((bz - az) * (cy - ay) - (cz - az) * dy) / area;
        let slope_y = ((cz - az) * dx - (bz - az) * (cx - ax)) / area;
        ((slope_x.abs() + slope_y.abs()) * (2.0 * radius as f64 / 256.0 + 1.0 / 64.0)).min(range)
    };
    (az + (bz - az) * s - push) * (1.0 - 2e-6)
}

fn check(corners: [Vertex; 3], radius: i64) -> usize {
    let targets = draw(corners, Pen { sides: [radius; 4], radius, fold: 0, off: 0.0 }, Fill::Stroke, SIZE);
    let c = corners.each_ref().map(place);
    let mut drawn = 0;
    for (&word, p) in targets.spare.iter().zip(centers(SIZE)) {
        let wanted = meets(c[0], c[1], p, radius.into()) && is_outer(c, p);
        assert_eq!(word != 0, wanted, "{corners:?}, radius {radius}, at {p:?}");
        if wanted {
            drawn += 1;
            assert!(is_edge(word));
            let (found, wanted) = (f64::from(depth_of(word)), depth(&corners, p, radius).max(0.0));
            assert!((found - wanted).abs() < 2e-6, "{corners:?}, radius {radius}, at {p:?}: {found}, not {wanted}");
        }
    }
    drawn
}

#[test]
fn strokes_are_the_pixels_within_the_pen() {
    let mut random = Random(5);
    let mut drawn = 0;
    for k in 0..6000 {
        let mut corners = [(); 3].map(|()| random.vertex(-4, 32));
        match k % 5 {
            // Points, axis-parallel and far segments, triangles without area.
            0 => corners[1] = Vertex { depth: corners[1].depth, ..corners[0] },
            1 => corners[1].y = corners[0].y,
            2 => corners[1] = random.vertex(-5000, 5000),
            3 => corners[2] = corners[k % 2],
            _ => {}
        }
        drawn += check(corners, 1 + random.below(300) as i64);
    }
    assert!(drawn > 50_000, "the segments missed the picture: {drawn} pixels");
}

/// Beside a triangle lies one without area: the grid folds along their common edge, which is stroked on both sides.
#[test]
fn folds_are_the_pixels_within_the_pen_on_both_sides() {
    let mut random = Random(6);
    let mut drawn = 0;
    for _ in 0..2000 {
        let corners = [(); 3].map(|()| random.vertex(-4, 32));
        let c = corners.each_ref().map(place);
        if area(c[0], c[1], c[2]) == 0 {
            continue;
        }
        let radius = 1 + random.below(300) as i64;
        // The first triangle is (0,0), (1,0), (1,1) of the quad: b and c are the ends of its diagonal's far corner.
        let targets = draw(corners, Pen { sides: [0; 4], radius: 0, fold: radius, off: 0.0 }, Fill::Stroke, SIZE);
        for (&word, p) in targets.spare.iter().zip(centers(SIZE)) {
            let border = meets(c[0], c[1], p, 0) && is_outer(c, p);
            let fold = meets(c[0], c[2], p, radius.into());
            assert_eq!(word != 0, border || fold, "{corners:?}, radius {radius}, at {p:?}");
            drawn += usize::from(fold);
        }
    }
    assert!(drawn > 20_000, "the folds missed the picture: {drawn} pixels");
}
