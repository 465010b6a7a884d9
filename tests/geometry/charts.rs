//! From points to parameters where there is no nearest one, or none that is easy to find.

use glam::{DVec3, DVec4};
use halfpixel::geometry::{Chart, NurbsSurface, SurfaceForm};

/// A ball of radius 2 as a rational biquadratic B-spline surface.
fn ball() -> NurbsSurface {
    let h = 0.5f64.sqrt();
    let square = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]];
    let half = [[0, -1], [1, -1], [1, 0], [1, 1], [0, 1]];
    let weight = |k: usize| if k % 2 == 0 { 1.0 } else { h };
    let mut points: Vec<DVec4> = Vec::new();
    for (i, [x, y]) in square.iter().enumerate() {
        for (j, [r, z]) in half.iter().enumerate() {
            let w = weight(i) * weight(j);
            points.push((DVec3::new(f64::from(x * r), f64::from(y * r), f64::from(*z)) * 2.0 * w).extend(w));
        }
    }
    let knots = |pieces: usize| {
        let inner = (1..pieces).flat_map(|k| [k as f64; 2]);
        [0.0; 3].into_iter().chain(inner).chain([pieces as f64; 3]).collect::<Vec<f64>>()
    };
    NurbsSurface::new("ball", [2, 2], [9, 5], [knots(4), knots(2)], points).expect("a ball")
}

#[test]
fn a_search_that_ends_without_proof_is_counted() {
    let chart = Chart::new(SurfaceForm::Nurbs(ball()), 1e-9, 1e-9);
    for direction in [DVec3::new(0.3, 0.4, 0.5), DVec3::new(-1.0, 0.2, -0.9)] {
        let point = direction * 1.7;
        let found = chart.position(chart.invert(point, None, 1e-9));
        assert!(found.distance(point.normalize() * 2.0) < 1e-9, "{found}");
    }
    assert_eq!(chart.unproved(), 0, "points off the centre have one nearest point");
    // From the centre all points are equally far: no box can be left out, and the search must end all the same.
    let found = chart.position(chart.invert(DVec3::ZERO, None, 1e-9));
    assert!((found.length() - 2.0).abs() < 1e-12);
    assert_eq!(chart.unproved(), 1);
}
