//! Faces on B-splines, extrusions and revolutions that stand for surfaces whose areas are known.

use super::*;
use crate::geometry::{BezierCurve, NurbsCurve, NurbsSurface};
use glam::DVec4;
use std::f64::consts::FRAC_PI_2;

/// Knots of a chain of Bézier pieces of `degree` over whole numbers.
fn knots(degree: usize, pieces: usize) -> Vec<f64> {
    let mut knots = vec![0.0; degree + 1];
    for k in 1..=pieces {
        let count = if k == pieces { degree + 1 } else { degree };
        knots.extend(std::iter::repeat_n(k as f64, count));
    }
    knots
}

fn chain(pieces: Vec<BezierCurve>) -> NurbsCurve {
    let (degree, count) = (pieces[0].degree(), pieces.len());
    let mut points = vec![pieces[0].points()[0]];
    pieces.iter().for_each(|piece| points.extend(&piece.points()[1..]));
    NurbsCurve::new("chain", degree, knots(degree, count), points).unwrap()
}

/// A profile turned once about the frame's z axis, as a NURBS whose u runs from 0 to 4.
fn turned(frame: &Frame, profile: &NurbsCurve) -> NurbsSurface {
    let w = FRAC_PI_2.cos().max(0.5f64.sqrt());
    let circle: [[f64; 3]; 9] = std::array::from_fn(|k| {
        let (s, c) = (k as f64 * FRAC_PI_2 / 2.0).sin_cos();
        if k % 2 == 0 { [c, s, 1.0] } else { [c, s, w] }
    });
    let mut points = Vec::new();
    for [c, s, k] in circle {
        for p in profile.points() {
            let q = p.truncate() - frame.origin * p.w;
            let along = frame.z * q.dot(frame.z);
            let out = q - along;
            points.push(((frame.origin * p.w + along) * k + out * c + frame.z.cross(out) * s).extend(p.w * k));
        }
    }
    let knots = [knots(2, 4), profile.knots().to_vec()];
    NurbsSurface::new("turned", [2, profile.degree()], [9, profile.points().len()], knots, points).unwrap()
}

fn straight(a: DVec3, b: DVec3) -> NurbsCurve {
    chain(vec![BezierCurve::line(a, b)])
}

fn conic(frame: &Frame, radii: [f64; 2], range: [f64; 2]) -> NurbsCurve {
    chain(crate::geometry::exact::ellipse(frame, radii, range).into_iter().map(|piece| piece.curve).collect())
}

/// The half plane through the frame's z axis and x, turned by `u`.
fn meridian(frame: &Frame, u: f64) -> Frame {
    let x = frame.x * u.cos() + frame.y * u.sin();
    Frame { origin: frame.origin, x, y: frame.z, z: x.cross(frame.z) }
}

/// Several forms of the same cylinder of radius 2 over heights from -1 to 5.
pub(super) fn cylinders(frame: Frame) -> Vec<SurfaceForm> {
    let profile = |h: [f64; 2]| h.map(|h| frame.point(2.0, 0.0, h));
    let [a, b] = profile([-1.0, 5.0]);
    let lifted = raised(frame, -1.0);
    let nurbs_circle = CurveForm::Nurbs(conic(&frame, [2.0, 2.0], [0.0, TAU]));
    vec![
        SurfaceForm::Nurbs(turned(&frame, &straight(a, b))),
        SurfaceForm::Revolution { profile: line(a, b), frame },
        SurfaceForm::Extrusion { profile: circle(lifted, 2.0, [0.0, TAU]), direction: frame.z * 3.0 },
        SurfaceForm::Extrusion { profile: circle(lifted, 2.0, [-1.0, TAU - 1.0]), direction: frame.z },
        SurfaceForm::Extrusion { profile: CurveSpan { curve: nurbs_circle, range: [0.0, 4.0] }, direction: frame.z },
    ]
}

/// A torus as a NURBS that closes both ways.
pub(super) fn turned_torus(frame: &Frame, [major, minor]: [f64; 2]) -> SurfaceForm {
    let half = meridian(frame, 0.0);
    let tube = Frame { origin: frame.origin + half.x * major, ..half };
    SurfaceForm::Nurbs(turned(frame, &conic(&tube, [minor, minor], [0.0, TAU])))
}

#[test]
fn cylinders_of_every_kind() {
    let frame = skew();
    let bottom = edge(1, circle(frame, 2.0, [0.0, TAU]));
    let top = edge(2, circle(raised(frame, 3.0), 2.0, [0.0, TAU]));
    let seam = edge(3, line(frame.point(2.0, 0.0, 0.0), frame.point(2.0, 0.0, 3.0)));
    let slanted = Frame::new(frame.point(0.0, 0.0, 3.0), frame.z - frame.x * 0.5, frame.x).unwrap();
    let cut =
        CurveSpan { curve: CurveForm::Ellipse { frame: slanted, radii: [5f64.sqrt(), 2.0] }, range: [TAU + 0.5, 0.5] };
    for surface in cylinders(frame) {
        let with_seam = vec![bottom.clone(), seam.clone(), back(&top), back(&seam)];
        let built = check(&face(surface.clone(), vec![with_seam]), TAU * 6.0);
        assert!(built.face.loops.is_empty(), "{:?}", built.face.loops);
        check(&face(surface, vec![vec![bottom.clone()], vec![edge(2, cut.clone())]]), TAU * 6.0);
    }
}

#[test]
fn spheres_of_every_kind() {
    let frame = skew();
    let half = meridian(&frame, 0.3);
    let range = [-FRAC_PI_2, FRAC_PI_2];
    let forms = [
        SurfaceForm::Nurbs(turned(&frame, &conic(&half, [2.0, 2.0], range))),
        SurfaceForm::Revolution { profile: circle(half, 2.0, range), frame },
    ];
    for surface in forms {
        check(&face(surface.clone(), vec![]), 16.0 * PI);
        let h: f64 = 0.7;
        let radius = (h * (4.0 - h)).sqrt();
        let cap = edge(1, circle(raised(frame, 2.0 - h), radius, [0.3, TAU + 0.3]));
        check(&face(surface.clone(), vec![vec![cap.clone()]]), TAU * 2.0 * h);
        check(&face(surface.clone(), vec![vec![back(&cap)]]), 16.0 * PI - TAU * 2.0 * h);
        let aside = Frame::new(frame.origin, frame.x - frame.y * 2.0 + frame.z * 0.3, frame.z).unwrap();
        let cap = edge(1, circle(raised(aside, 2.0 - h), radius, [0.0, TAU]));
        check(&face(surface.clone(), vec![vec![cap.clone()]]), TAU * 2.0 * h);
        check(&face(surface.clone(), vec![vec![back(&cap)]]), 16.0 * PI - TAU * 2.0 * h);
        let lune = vec![
            edge(1, circle(meridian(&frame, 1.3), 2.0, range)),
            edge(2, circle(meridian(&frame, 0.2), 2.0, [FRAC_PI_2, -FRAC_PI_2])),
        ];
        check(&face(surface, vec![lune]), 1.1 * 8.0);
    }
}

/// A surface of degree 22 in v: the graph of a polynomial that is a paraboloid in fact.
fn paraboloid() -> NurbsSurface {
    let rows: Vec<DVec4> = (0..3)
        .flat_map(|i| {
            let (x, xx) = ([-1.0, 0.0, 1.0][i], [1.0, -1.0, 1.0][i]);
            let line: Vec<DVec4> =
                [(-1.0, 1.0), (0.0, -1.0), (1.0, 1.0)].map(|(y, yy)| DVec4::new(x, y, xx + yy, 1.0)).to_vec();
            BezierCurve::new("row", line).unwrap().elevate(22).points().to_vec()
        })
        .collect();
    NurbsSurface::new("paraboloid", [2, 22], [3, 23], [knots(2, 1), knots(22, 1)], rows).unwrap()
}

#[test]
fn circle_on_a_paraboloid_of_degree_22() {
    let surface = SurfaceForm::Nurbs(paraboloid());
    let r: f64 = 0.8;
    let frame = Frame { origin: DVec3::new(0.0, 0.0, r * r), ..Frame::IDENTITY };
    let bound = edge(1, circle(frame, r, [0.0, TAU]));
    // z = x² + y² over the disc: π/6 ((1 + 4 r²)^(3/2) - 1).
    let area = PI / 6.0 * ((1.0 + 4.0 * r * r).powf(1.5) - 1.0);
    check(&face(surface.clone(), vec![vec![bound.clone()]]), area);
    // Wound the wrong way, on a surface with borders.
    check(&face(surface, vec![vec![back(&bound)]]), area);
}

#[test]
fn offsets_of_every_kind() {
    let frame = skew();
    let surfaces = cylinders(frame).into_iter().chain([SurfaceForm::Cylinder { frame, radius: 2.0 }]);
    let (bottom, top) = (circle(frame, 2.5, [0.0, TAU]), circle(raised(frame, 3.0), 2.5, [TAU + 0.4, 0.4]));
    for base in surfaces {
        let exact = matches!(base, SurfaceForm::Cylinder { .. });
        let offset = SurfaceForm::Offset { base: Box::new(base), distance: 0.5 };
        let bounds = vec![vec![edge(1, bottom.clone())], vec![edge(2, top.clone())]];
        let built = check(&face(offset, bounds), TAU * 7.5);
        assert_eq!(built.warnings.iter().any(|w| w.contains("offset")), !exact, "{:?}", built.warnings);
    }
}

#[test]
fn edge_off_the_surface_is_kept_and_named() {
    let frame = skew();
    let far = 1e-4;
    let bottom = edge(7, circle(frame, 2.0 + far, [0.0, TAU]));
    let top = edge(8, circle(raised(frame, 3.0), 2.0, [TAU, 0.0]));
    for surface in cylinders(frame) {
        let built = build_face(&face(surface, vec![vec![bottom.clone()], vec![top.clone()]])).unwrap();
        assert!((measure::area(&built.face) - TAU * 6.0).abs() < 1e-9);
        assert!(built.warnings.iter().any(|w| w.contains("#7") && w.contains("1.00e-4")), "{:?}", built.warnings);
        assert!(!built.warnings.iter().any(|w| w.contains("#8")), "{:?}", built.warnings);
    }
}
