//! Bad data is named, never evaluated.

use glam::DVec4;
use halfpixel::geometry::GeometryError::{self, *};
use halfpixel::geometry::{BezierCurve, BezierPatch, Knots, NurbsCurve, NurbsSurface};

fn points(count: usize) -> Vec<DVec4> {
    (0..count).map(|k| DVec4::new(k as f64, 1.0, 2.0, 1.0)).collect()
}

fn curve(degree: usize, knots: &[f64], points: Vec<DVec4>) -> GeometryError {
    NurbsCurve::new("curve #17", degree, knots.to_vec(), points).expect_err("bad data")
}

#[test]
fn knots() {
    let what = || String::from("curve #17");
    assert_eq!(curve(1, &[0.0, 0.0, 1.0], points(2)), KnotCount { what: what(), expected: 4, found: 3 });
    let decreasing = DecreasingKnots { what: what(), index: 3, before: 2.0, value: 1.0 };
    assert_eq!(curve(2, &[0.0, 0.0, 2.0, 1.0, 3.0, 3.0], points(3)), decreasing);
    assert_eq!(curve(1, &[0.0, 0.0, f64::NAN, 1.0], points(2)), KnotNotFinite { what: what(), index: 2 });
    assert_eq!(curve(1, &[0.0, 1.0, 1.0, 2.0], points(2)), EmptyDomain { what: what(), value: 1.0 });
    assert!(matches!(curve(1, &[-1e308, -1e308, 1e308, 1e308], points(2)), BadShape { .. }));
    let message = curve(2, &[0.0, 0.0, 2.0, 1.0, 3.0, 3.0], points(3)).to_string();
    assert_eq!(message, "curve #17: knot 3 (1) is smaller than the one before it (2)");
}

#[test]
fn degrees_and_counts() {
    let clamped = |degree: usize| [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    assert!(matches!(curve(0, &[0.0, 1.0], points(1)), BadDegree { degree: 0, max: 63, .. }));
    assert!(matches!(curve(64, &clamped(64), points(65)), BadDegree { degree: 64, .. }));
    assert!(NurbsCurve::new("highest", 63, clamped(63), points(64)).is_ok());
    assert!(matches!(curve(3, &clamped(2), points(3)), PointCount { expected: 4, found: 3, .. }));
    assert!(matches!(BezierCurve::new("point", points(1)), Err(BadDegree { degree: 0, .. })));
    assert!(matches!(BezierPatch::new("patch", [1, 1], points(5)), Err(PointCount { expected: 4, found: 5, .. })));
    assert!(Knots::periodic("none", 3, &[]).is_err());
    assert!(NurbsCurve::periodic("ring", 3, &[0.0, 1.0, 2.0], &points(3)).is_err());
}

#[test]
fn surfaces_name_the_direction() {
    let line = || vec![0.0, 0.0, 1.0, 1.0];
    let bad = NurbsSurface::new("face #4", [1, 1], [2, 2], [line(), vec![0.0; 4]], points(4)).expect_err("empty");
    assert_eq!(bad, EmptyDomain { what: "face #4, v direction".into(), value: 0.0 });
    let bad = NurbsSurface::new("face #4", [1, 1], [2, 2], [line(), line()], points(3)).expect_err("count");
    assert_eq!(bad, PointCount { what: "face #4".into(), expected: 4, found: 3 });
}

#[test]
fn weights_and_coordinates() {
    for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut bad = points(4);
        bad[2].w = weight;
        let error = BezierPatch::new("patch", [1, 1], bad).expect_err("weight");
        assert!(matches!(error, BadWeight { index: 2, .. }), "{error}");
    }
    for value in [f64::NAN, f64::NEG_INFINITY] {
        let mut bad = points(2);
        bad[1].y = value;
        assert!(matches!(curve(1, &[0.0, 0.0, 1.0, 1.0], bad), PointNotFinite { index: 1, .. }));
    }
}

#[test]
fn exact_forms_of_senseless_numbers() {
    use halfpixel::geometry::PatchPiece;
    use halfpixel::geometry::exact::{Frame, sphere, torus};
    let checked = |pieces| PatchPiece::checked("face #9", pieces);
    assert!(checked(sphere(&Frame::IDENTITY, f64::NAN, [[0.0, 1.0], [0.0, 1.0]])).is_err());
    assert!(checked(sphere(&Frame::IDENTITY, 1.0, [[0.0, f64::INFINITY], [0.0, 1.0]])).is_err());
    assert!(checked(torus(&Frame::IDENTITY, 2.0, 1.0, [[0.0, 1e300], [0.0, 1.0]])).is_err());
    assert!(checked(torus(&Frame::IDENTITY, 2.0, 1.0, [[0.0, 9.0], [-4.0, 1.0]])).is_ok());
}
