//! Plane sections of ruled surfaces: their images are exact, and so what lies on both is known.

use super::*;
use crate::geometry::{NurbsCurve, NurbsSurface};
use std::f64::consts::FRAC_PI_2;

/// The greatest distance from a plane of the images of the curves of edge 2; also checks that they are no approximations.
fn off_plane(built: &Built, [origin, normal]: [DVec3; 2]) -> f64 {
    assert_eq!(built.face.approximation, crate::model::Approximation::default());
    let curves = built.face.loops.iter().flat_map(|l| &l.curves).filter(|c| c.edge == Some(2));
    let mut worst: f64 = 0.0;
    let mut count = 0;
    for curve in curves {
        for k in 0..=16 {
            let p = curve.curve.position(f64::from(k) / 16.0);
            let holds = |patch: &&crate::model::SurfacePatch| {
                let [[u0, u1], [v0, v1]] = patch.domain;
                (u0 - 1e-9..=u1 + 1e-9).contains(&p.x) && (v0 - 1e-9..=v1 + 1e-9).contains(&p.y)
            };
            let patch = built.face.surface.patches.iter().find(holds).expect("a patch under the curve");
            let part = |t: f64, [a, b]: [f64; 2]| (t - a) / (b - a);
            let x = patch.patch.net().position(part(p.x, patch.domain[0]), part(p.y, patch.domain[1]));
            worst = worst.max((x - origin).dot(normal).abs());
            count += 1;
        }
    }
    assert!(count > 0, "edge 2 has no curve");
    worst
}

#[test]
fn ellipses_on_a_cylinder() {
    for (tilt, start) in [(0.3, 0.0), (0.9, 1.0), (1.4, 4.5)] {
        let f = skew();
        let surface = SurfaceForm::Cylinder { frame: f, radius: 2.0 };
        let axis = f.z * f64::cos(tilt) + (f.x * 0.6 + f.y * 0.8) * f64::sin(tilt);
        let across = f.z.cross(axis).normalize();
        let frame = Frame::new(f.point(0.0, 0.0, 20.0), axis, axis.cross(across)).unwrap();
        let curve = CurveForm::Ellipse { frame, radii: [2.0 / tilt.cos(), 2.0] };
        let rim = edge(2, CurveSpan { curve, range: [start, start + TAU] });
        let low = edge(1, circle(f, 2.0, [0.0, TAU]));
        // Over a full turn the oblique plane is as high as on the axis.
        let built = check(&face(surface, vec![vec![low], vec![back(&rim)]]), TAU * 2.0 * 20.0);
        let off = off_plane(&built, [frame.origin, frame.z]);
        assert!(off < 1e-13, "{off:e} at {tilt}");
        let degrees = built.face.loops.iter().flat_map(|l| &l.curves).map(|c| c.curve.degree());
        assert_eq!(degrees.max(), Some(3));
    }
}

/// A quarter of a cylinder of radius 3 and height 5 as a B-spline surface, cut by a plane; the edge is a B-spline too.
#[test]
fn sections_of_ruled_splines_given_as_splines() {
    let w = 0.5f64.sqrt();
    let arc = [[3.0, 0.0, 1.0], [3.0, 3.0, w], [0.0, 3.0, 1.0]];
    let point = |[x, y, w]: [f64; 3], z: f64| (DVec3::new(x, y, z) * w).extend(w);
    let knots = |degree: usize| [vec![0.0; degree + 1], vec![1.0; degree + 1]].concat();
    let net = arc.iter().flat_map(|&a| [point(a, 0.0), point(a, 5.0)]).collect();
    let surface = NurbsSurface::new("quarter", [2, 1], [3, 2], [knots(2), knots(1)], net).unwrap();
    // z = 2 + x / 2 + y / 3: the lift of the arc's control points.
    let height = |x: f64, y: f64| 2.0 + x / 2.0 + y / 3.0;
    let high: Vec<_> = arc.iter().map(|&a| point(a, height(a[0], a[1]))).collect();
    let high = NurbsCurve::new("section", 2, knots(2), high).unwrap();
    let top = edge(2, CurveSpan { curve: CurveForm::Nurbs(high), range: [0.0, 1.0] });
    let bottom = edge(1, circle(Frame::IDENTITY, 3.0, [0.0, FRAC_PI_2]));
    let side = |x: f64, y: f64, number| edge(number, line(DVec3::new(x, y, 0.0), DVec3::new(x, y, height(x, y))));
    let [right, left] = [side(3.0, 0.0, 3), side(0.0, 3.0, 4)];
    let right = EdgeUse { edge: 3, ..right };
    let bounds = vec![bottom, left, back(&top), back(&right)];
    let source = face(SurfaceForm::Nurbs(surface), vec![bounds]);
    // 3 times the integral of 2 + 1.5 cos + sin over the quarter.
    let built = check(&source, 3.0 * (2.0 * FRAC_PI_2 + 1.5 + 1.0));
    let normal = DVec3::new(-0.5, -1.0 / 3.0, 1.0).normalize();
    let off = off_plane(&built, [DVec3::new(0.0, 0.0, 2.0), normal]);
    assert!(off < 1e-13, "{off:e}");
}

#[test]
fn what_is_no_plane_section_is_fitted_and_counted() {
    // Where another cylinder comes through: a saddle curve, here by points close enough to be that curve.
    let surface = SurfaceForm::Cylinder { frame: Frame::IDENTITY, radius: 2.0 };
    let at = |k: usize| {
        let t = (k as f64 / 96.0) * TAU;
        let [y, z] = [t.cos(), t.sin()];
        DVec3::new((4.0 - y * y).sqrt(), y, z).extend(1.0)
    };
    let points: Vec<_> = (0..=96).map(at).collect();
    let knots = (0..=98).map(|k: usize| k.saturating_sub(1).min(96) as f64).collect();
    let curve = NurbsCurve::new("saddle", 1, knots, points).unwrap();
    let hole = edge(2, CurveSpan { curve: CurveForm::Nurbs(curve), range: [0.0, 96.0] });
    let rims = [-3.0, 3.0].map(|z| edge(1, circle(raised(Frame::IDENTITY, z), 2.0, [0.0, TAU])));
    let bounds = vec![vec![rims[0].clone()], vec![back(&rims[1])], vec![back(&hole)]];
    let built = build_face(&FaceSource { tolerance: 1e-2, ..face(surface, bounds) }).unwrap();
    assert!(built.face.approximation.curves >= 40, "{:?}", built.face.approximation);
    assert!(built.face.approximation.error < 1e-8);
}

/// A loop that lies a thousand turns away would ask for a thousand copies of all patches.
#[test]
fn loops_many_turns_away_are_lost_with_a_reason() {
    let surface = SurfaceForm::Cylinder { frame: Frame::IDENTITY, radius: 2.0 };
    // A coil: 150 turns up, then straight down.
    let at = |k: usize| {
        let t = k as f64 / 16.0 * TAU;
        DVec3::new(2.0 * t.cos(), 2.0 * t.sin(), t * 0.1).extend(1.0)
    };
    let points: Vec<_> = (0..=2400).map(at).collect();
    let knots = (0..=2402).map(|k: usize| k.saturating_sub(1).min(2400) as f64).collect();
    let coil = NurbsCurve::new("coil", 1, knots, points.clone()).unwrap();
    let up = edge(2, CurveSpan { curve: CurveForm::Nurbs(coil), range: [0.0, 2400.0] });
    let down = edge(3, line(points[2400].truncate(), points[0].truncate()));
    let error = build_face(&face(surface, vec![vec![up, down]])).unwrap_err();
    assert!(matches!(error, BrepError::Turns), "{error}");
}

/// A parallelogram as a B-spline surface, seen through a round hole's edge.
#[test]
fn conics_on_planes_that_are_written_as_splines() {
    let f = skew();
    let (u, v) = (f.x * 8.0, f.x * 2.0 + f.y * 6.0);
    let corner = |a: f64, b: f64| (f.origin + u * a + v * b).extend(1.0);
    let net = vec![corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 0.0), corner(1.0, 1.0)];
    let knots = [vec![1.0, 1.0, 3.0, 3.0], vec![-2.0, -2.0, 5.0, 5.0]];
    let surface = NurbsSurface::new("plane", [1, 1], [2, 2], knots, net).unwrap();
    let at = |a: f64, b: f64| corner(a, b).truncate();
    let corners = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
    let outer = (0..4).map(|k| edge(3, line(corners[k], corners[(k + 1) % 4]))).collect();
    let center = Frame { origin: at(0.5, 0.5), ..f };
    let ellipse = CurveForm::Ellipse { frame: center, radii: [2.0, 1.0] };
    let hole = edge(2, CurveSpan { curve: ellipse, range: [0.3, 0.3 + TAU] });
    let built = check(&face(SurfaceForm::Nurbs(surface), vec![outer, vec![back(&hole)]]), 48.0 - 2.0 * PI);
    let off = off_plane(&built, [f.origin, f.z]);
    assert!(off < 1e-14 * 8.0, "{off:e}");
    let curves = || built.face.loops.iter().flat_map(|l| &l.curves).filter(|c| c.edge == Some(2));
    assert_eq!((curves().count(), curves().map(|c| c.curve.degree()).max()), (4, Some(2)));
    assert!(curves().all(|c| c.gap < 1e-13));
}
