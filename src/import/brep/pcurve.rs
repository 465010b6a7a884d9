//! The file's own images of edges, where they are as good as a projection.

use super::trace::{Path, Shape, Source, standard};
use super::{EdgeUse, Scale};
use crate::geometry::{BezierCurve, Chart, CurvePiece, CurveSpan, SurfaceForm};
use glam::{DVec2, DVec4};

/// Places along an image where it is compared with its edge.
const SAMPLES: usize = 12;

/// The edge's image as the file gives it, on a B-spline surface: where it is no farther from the edge than the surface
/// itself is, or than matters. (A projection is never farther off, so nothing else is gained by the file's own.)
pub(super) fn file_image<'a>(
    chart: &Chart,
    scale: &Scale,
    edge: &'a EdgeUse,
    near: Option<DVec2>,
) -> Option<Vec<Path<'a>>> {
    let ([span], SurfaceForm::Nurbs(_)) = (&edge.spans[..], chart.form()) else { return None };
    let start = |image: &Vec<CurveSpan>| image.first().map(|s| s.ends()[0].truncate());
    let distance = |image: &Vec<CurveSpan>| match (near, start(image)) {
        (Some(near), Some(start)) => near.distance(start),
        _ => 0.0,
    };
    // On a seam the file gives both images: the one that goes on from where the loop is.
    let mut images: Vec<&Vec<CurveSpan>> = edge.pcurves.iter().filter(|image| !image.is_empty()).collect();
    images.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let image = images.into_iter().find(|image| agrees(chart, scale, span, image))?;
    let pieces: Vec<CurvePiece> = image.iter().flat_map(CurveSpan::pieces).collect();
    let count = pieces.len() as f64;
    let [a, b] = span.range;
    let range = |k: usize| [k as f64, (k + 1) as f64].map(|k| a + (b - a) * k / count);
    let paths = pieces.into_iter().enumerate().map(|(k, piece)| {
        let source = Source { edge: edge.edge, span, range: range(k) };
        path(chart, scale, piece.curve, source)
    });
    Some(paths.collect())
}

/// Whether the image runs along the edge in its direction, as near to it as the surface is.
fn agrees(chart: &Chart, scale: &Scale, span: &CurveSpan, image: &[CurveSpan]) -> bool {
    let [a, b] = span.range;
    let ends = [image.first().map(|s| s.ends()[0]), image.last().map(|s| s.ends()[1])];
    let ends_agree = ends.iter().zip(span.ends()).all(|(uv, p)| {
        uv.is_some_and(|uv| uv.is_finite() && chart.position(uv.truncate()).distance(p) <= 2.0 * scale.accept)
    });
    if !ends_agree {
        return false;
    }
    let pieces = image.len() as f64;
    let (mut off, mut free) = (0.0f64, 0.0f64);
    for k in 0..=SAMPLES {
        let s = k as f64 / SAMPLES as f64;
        let piece = ((s * pieces) as usize).min(image.len() - 1);
        let [t0, t1] = image[piece].range;
        let uv = image[piece].curve.position(t0 + (t1 - t0) * (s * pieces - piece as f64)).truncate();
        let x = chart.position(uv);
        let (t, distance) = span.nearest(x, a + (b - a) * s);
        let p = span.curve.position(t);
        off = off.max(distance);
        free = free.max(chart.position(chart.invert(p, Some(uv), f64::INFINITY)).distance(p));
        if off > 2.0 * scale.accept {
            return false;
        }
    }
    off <= scale.straight.max(1.5 * free)
}

fn path<'a>(chart: &Chart, scale: &Scale, curve: BezierCurve, source: Source<'a>) -> Path<'a> {
    let mut points: Vec<DVec4> = curve.points().iter().map(|p| DVec4::new(p.x, p.y, 0.0, p.w)).collect();
    standard(&mut points);
    let [mut start, mut end] = [points[0], points[points.len() - 1]].map(|p| p.truncate().truncate());
    let pole = |uv: DVec2| {
        let point = chart.position(uv);
        chart.poles().iter().find(|pole| pole.point.distance(point) <= scale.pole).copied()
    };
    let poles = [pole(start), pole(end)];
    let speed = chart.surface_point(0.5 * (start + end));
    let speed = [speed.du.length(), speed.dv.length()];
    // A line along the surface's border or a knot line is that line, bit for bit.
    for axis in 0..2 {
        let values = || points.iter().map(|p| p[axis] / p.w);
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
        if (high - low) * speed[axis] <= scale.straight && (end - start).length() > 2.0 * (high - low) {
            let middle = 0.5 * (low + high);
            let limits = chart.form().limits()[axis];
            let near = limits.into_iter().find(|end| (end - middle).abs() * speed[axis] <= scale.straight);
            (start[axis], end[axis]) = (near.unwrap_or(middle), near.unwrap_or(middle));
            return Path { start, end, shape: Shape::Straight, source: Some(source), poles };
        }
    }
    Path { start, end, shape: Shape::Exact(BezierCurve::from_points(points)), source: Some(source), poles }
}
