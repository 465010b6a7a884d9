//! Loops on surfaces of every kind, judged by second methods: areas known in closed form, images against edges.

mod analytic;
mod freeform;
mod measure;
mod sections;
mod windows;

use super::*;
use crate::geometry::exact::Frame;
use std::f64::consts::{PI, TAU};

/// A placement with nothing aligned to the axes.
pub(super) fn skew() -> Frame {
    Frame::new(DVec3::new(3.0, -2.0, 5.0), DVec3::new(0.3, -0.5, 0.8), DVec3::new(1.0, 0.4, -0.2)).unwrap()
}

pub(super) fn line(a: DVec3, b: DVec3) -> CurveSpan {
    CurveSpan { curve: CurveForm::Line { origin: a, direction: b - a }, range: [0.0, 1.0] }
}

pub(super) fn circle(frame: Frame, radius: f64, range: [f64; 2]) -> CurveSpan {
    CurveSpan { curve: CurveForm::Ellipse { frame, radii: [radius, radius] }, range }
}

pub(super) fn edge(number: u32, span: CurveSpan) -> EdgeUse {
    EdgeUse { edge: number, ends: span.ends(), spans: vec![span], pcurves: Vec::new() }
}

/// The edge run through the other way.
pub(super) fn back(edge: &EdgeUse) -> EdgeUse {
    let turn = |span: &CurveSpan| CurveSpan { curve: span.curve.clone(), range: [span.range[1], span.range[0]] };
    EdgeUse {
        edge: edge.edge,
        spans: edge.spans.iter().rev().map(turn).collect(),
        pcurves: Vec::new(),
        ends: [edge.ends[1], edge.ends[0]],
    }
}

pub(super) fn face(surface: SurfaceForm, bounds: Vec<Vec<EdgeUse>>) -> FaceSource {
    FaceSource {
        id: 1,
        name: String::new(),
        color: None,
        kind: SurfaceKind::Plane,
        surface,
        domain: None,
        bounds: bounds.into_iter().map(Bound::Edges).collect(),
        reversed: false,
        tolerance: 1e-6,
    }
}

/// The frame moved along its z axis.
pub(super) fn raised(frame: Frame, z: f64) -> Frame {
    Frame { origin: frame.point(0.0, 0.0, z), ..frame }
}

/// Builds the face and checks what must hold for every face: loops closed bit for bit, gaps tiny, area as given.
pub(super) fn check(source: &FaceSource, area: f64) -> Built {
    let built = build_face(source).unwrap();
    measure::closed(&built.face);
    let gap = built.face.loops.iter().flat_map(|l| &l.curves).map(|c| c.gap).fold(0.0, f64::max);
    assert!(gap < 1e-7, "gap {gap}");
    let found = measure::area(&built.face);
    assert!((found - area).abs() < 1e-7 * area, "area {found}, expected {area}; {:#?}", built.face.loops);
    built
}
