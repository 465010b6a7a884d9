//! Faces of boundary representations: from edges in space to loops of rational Bézier curves in the parameter plane.
//!
//! A reader of STEP or the like hands over a [`FaceSource`]; [`build_face`] makes the [`Face`] of it.

mod bands;
mod clip;
mod cover;
mod fit;
mod flat;
mod pcurve;
mod ring;
mod section;
#[cfg(test)]
mod tests;
mod trace;

use crate::geometry::{Chart, CurveForm, CurveSpan, GeometryError, SurfaceForm};
use crate::model::{Face, Loop, Surface, SurfaceKind, TrimCurve};
use cover::{Rectangle, closed_rings, whole_about};
use fit::Fitter;
use glam::{DVec2, DVec3};
use ring::Ring;
use thiserror::Error;

/// One edge as a loop runs along it.
#[derive(Clone, Debug)]
pub(crate) struct EdgeUse {
    /// Entity number of the edge.
    pub edge: u32,
    /// In model units, in the loop's direction from start to end vertex, joined end to end.
    pub spans: Vec<CurveSpan>,
    /// The file's candidates on this face's surface: z = 0, in the surface's ISO 10303-42 parameters, same direction;
    /// none, one, or two on a seam.
    pub pcurves: Vec<Vec<CurveSpan>>,
    /// The vertices, in the loop's direction.
    pub ends: [DVec3; 2],
}

/// A bound of a face.
#[derive(Clone, Debug)]
pub(crate) enum Bound {
    Edges(Vec<EdgeUse>),
    Vertex(DVec3),
}

/// A face before its loops are in the parameter plane.
#[derive(Clone, Debug)]
pub(crate) struct FaceSource {
    pub id: u32,
    pub name: String,
    pub color: Option<[f32; 3]>,
    pub kind: SurfaceKind,
    pub surface: SurfaceForm,
    /// Of a rectangular trimmed surface: bounds in the surface's parameters.
    pub domain: Option<[[f64; 2]; 2]>,
    /// In the direction that has the material to its left seen from `S_u x S_v`, if the file is right.
    pub bounds: Vec<Bound>,
    /// The face's outward normal is `-(S_u x S_v)`.
    pub reversed: bool,
    /// The file's uncertainty, in model units.
    pub tolerance: f64,
}

/// A face and what was mended in it.
#[derive(Clone, Debug)]
pub(crate) struct Built {
    pub face: Face,
    pub warnings: Vec<String>,
}

/// Why a face is lost.
#[derive(Clone, Debug, Error)]
pub(crate) enum BrepError {
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("the face has no bounds and its surface is unbounded")]
    Unbounded,
    #[error(
        "a loop winds {u} times around the surface along u and {v} times along v: it crosses itself or another loop"
    )]
    Winding { u: i32, v: i32 },
    #[error("a loop that winds around the surface has no partner to bound the face with")]
    NoPartner,
    #[error("a loop goes more than {MAX_TURNS} times around the surface")]
    Turns,
    #[error("a seam crosses an edge more than {MAX_CUTS} times")]
    Cuts,
}

/// Periods that a loop may lie from where the surface begins: copies of patches and loops are made for each.
const MAX_TURNS: f64 = 100.0;
/// Cuts of one part of an edge.
const MAX_CUTS: usize = 1000;

/// Lengths that decide, in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Edges are on the surface to within this.
    accept: f64,
    /// Along an edge points may be this far off the surface before the nearest one is sought all over it.
    follow: f64,
    /// Fits are at least this near.
    fine: f64,
    /// Images that are this near to a straight line along one parameter are that line.
    straight: f64,
    /// Ends that are this near are made one.
    snap: f64,
    /// Edges that come this near to a pole run through it.
    pole: f64,
}

impl Scale {
    /// For a face of extent `size`, at most `reach` from the origin.
    fn new(size: f64, reach: f64, tolerance: f64) -> Self {
        let least = (1e-9 * size).max(4e-15 * reach);
        Self {
            accept: tolerance.max(1e-6 * size),
            follow: (10.0 * tolerance).max(1e-3 * size),
            fine: least,
            straight: least.max((1e-3 * tolerance).min(1e-7 * size)),
            snap: least.max((1e-2 * tolerance).min(1e-7 * size)),
            pole: least.max(tolerance.min(1e-5 * size)),
        }
    }
}

/// Extent of the bounds and their farthest coordinate.
fn extent(source: &FaceSource) -> (f64, f64) {
    let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let mut add = |p: DVec3| bounds = [bounds[0].min(p), bounds[1].max(p)];
    for bound in &source.bounds {
        match bound {
            Bound::Vertex(p) => add(*p),
            Bound::Edges(edges) => {
                for span in edges.iter().flat_map(|edge| &edge.spans) {
                    let [a, b] = span.range;
                    let inner = if matches!(span.curve, CurveForm::Line { .. }) { 1 } else { 4 };
                    (0..=inner).for_each(|k| add(span.curve.position(a + (b - a) * (f64::from(k) / f64::from(inner)))));
                }
            }
        }
    }
    let size = (bounds[1] - bounds[0]).length();
    if !(size > 0.0 && size.is_finite()) {
        return (1.0, 1.0);
    }
    (size, bounds[0].abs().max(bounds[1].abs()).max_element())
}

/// The face with its loops in the surface's parameter plane and the patches that cover them.
///
/// # Errors
/// Where the face can't be shown as it is meant: it has no extent, its numbers are out of range, or its loops wind around
/// the surface so that they bound nothing.
pub(crate) fn build_face(source: &FaceSource) -> Result<Built, BrepError> {
    let (size, reach) = extent(source);
    let scale = Scale::new(size, reach, source.tolerance);
    let chart =
        Chart::new(source.surface.clone(), source.tolerance.min(1e-6 * size).max(scale.fine), 10.0 * scale.fine);
    let mut warnings = Vec::new();
    let mut rings = Vec::with_capacity(source.bounds.len());
    for bound in &source.bounds {
        if let Bound::Edges(edges) = bound {
            rings.extend(Ring::new(&chart, &scale, edges));
        }
    }
    if rings.iter().any(|ring| is_far(&chart, ring)) {
        return Err(BrepError::Turns);
    }
    let mut rings = closed_rings(&chart, rings, &mut warnings)?;
    rings.iter_mut().for_each(|ring| ring.join(&chart, &scale));
    let area = match area(&chart, &rings) {
        Some(area) => area,
        None => source.domain.unwrap_or_else(|| whole_about(&chart, DVec2::ZERO)),
    };
    if !area.iter().flatten().all(|t| t.is_finite()) {
        return Err(BrepError::Unbounded);
    }
    let surface: Surface = chart.patches(area)?.into();
    let mut fitter = Fitter::new(&chart, area, &surface.patches, &scale);
    let loops = rings.iter().map(|ring| {
        let mut curves = Vec::with_capacity(ring.paths.len());
        ring.paths.iter().for_each(|path| fitter.curves(path, &mut curves));
        Loop { curves }
    });
    let loops: Vec<Loop> = loops.filter(|l| !l.curves.is_empty()).collect();
    let Fitter { worst, approximation, .. } = fitter;
    // A fit as near as was asked for needs no mention, however fine the file's tolerance is.
    let fit = Some(worst).filter(|&worst| worst > scale.fine);
    note_gaps(source, &chart, &rings, &loops, fit, &mut warnings);
    let loops = if is_whole(&loops, area, scale.straight) { Vec::new() } else { loops };
    let FaceSource { id, name, color, kind, reversed, .. } = source;
    let face = Face {
        id: *id,
        name: name.as_str().into(),
        color: *color,
        kind: *kind,
        surface,
        loops: loops.into(),
        reversed: *reversed,
        approximation,
    };
    Ok(Built { face, warnings })
}

/// Whether a ring lies too many periods from the surface's own domain.
fn is_far(chart: &Chart, ring: &Ring) -> bool {
    let [low, high] = ring.bounds();
    let limits = chart.form().limits();
    (0..2).any(|axis| {
        let Some(period) = chart.periods()[axis] else { return false };
        let start = if limits[axis][0].is_finite() { limits[axis][0] } else { 0.0 };
        let turns = [low[axis], high[axis]].map(|t| ((t - start) / period).abs());
        // Also true for what is no number.
        !turns.iter().all(|&turns| turns < MAX_TURNS)
    })
}

/// Edges that name themselves in a warning; the rest are counted.
const NAMED_EDGES: usize = 4;

/// Warns of what is farther off than the file's tolerance allows.
fn note_gaps(
    source: &FaceSource,
    chart: &Chart,
    rings: &[Ring],
    loops: &[Loop],
    fit: Option<f64>,
    warnings: &mut Vec<String>,
) {
    let tolerance = source.tolerance;
    if let Some(error) = chart.error() {
        warnings.push(format!("the offset surface is fitted to within {error:.2e} mm"));
    }
    if chart.unproved() > 0 {
        let count = chart.unproved();
        warnings.push(format!("{count} points of edges may have nearer ones on the surface: the search ended first"));
    }
    let bridged = rings.iter().map(|ring| ring.bridged).fold(0.0, f64::max);
    if bridged > tolerance {
        warnings.push(format!("edges of a loop miss each other by {bridged:.2e} mm; a straight line joins them"));
    }
    if let Some(fit) = fit.filter(|&fit| fit > 1e-3 * tolerance) {
        warnings.push(format!("trim curves are fitted to within {fit:.2e} mm only"));
    }
    let mut off: Vec<(u32, f64)> = Vec::new();
    for curve in loops.iter().flat_map(|l| &l.curves).filter(|curve| curve.gap > tolerance) {
        let Some(edge) = curve.edge else { continue };
        match off.iter_mut().find(|(number, _)| *number == edge) {
            Some((_, gap)) => *gap = gap.max(curve.gap),
            None => off.push((edge, curve.gap)),
        }
    }
    for (edge, gap) in off.iter().take(NAMED_EDGES) {
        warnings.push(format!("edge #{edge} is up to {gap:.2e} mm off the surface (tolerance {tolerance:.2e} mm)"));
    }
    if off.len() > NAMED_EDGES {
        let (count, worst) = (off.len(), off.iter().map(|e| e.1).fold(0.0, f64::max));
        warnings.push(format!("{count} edges are off the surface in all, up to {worst:.2e} mm"));
    }
}

/// The box of all rings in the surface's parameters.
fn area(chart: &Chart, rings: &[Ring]) -> Option<Rectangle> {
    let mut bounds = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    for path in rings.iter().flat_map(|ring| &ring.paths) {
        let [low, high] = path.bounds();
        bounds = [bounds[0].min(low), bounds[1].max(high)];
    }
    let [low, high] = bounds;
    let limits = chart.form().limits();
    let clamped = [0, 1].map(|axis| match chart.periods()[axis] {
        Some(_) => [low[axis], high[axis]],
        None => [low[axis].max(limits[axis][0]), high[axis].min(limits[axis][1])],
    });
    (low.x <= high.x).then_some(clamped)
}

/// Whether one loop runs along the border of `area` and nowhere else, its edges there to within `tolerance`.
fn is_whole(loops: &[Loop], area: Rectangle, tolerance: f64) -> bool {
    let [only] = loops else { return false };
    let mut twice = 0.0;
    for TrimCurve { curve, gap, .. } in &only.curves {
        let [a, b] = [curve.points()[0], curve.points()[curve.degree()]];
        let on_border = |axis: usize| a[axis] == b[axis] && area[axis].contains(&a[axis]);
        if curve.degree() != 1 || *gap > tolerance || !(on_border(0) || on_border(1)) {
            return false;
        }
        let corner = DVec2::new(area[0][0], area[1][0]);
        twice += (a.truncate().truncate() - corner).perp_dot(b.truncate().truncate() - corner);
    }
    let whole = (area[0][1] - area[0][0]) * (area[1][1] - area[1][0]);
    (twice.abs() * 0.5 - whole).abs() <= 1e-9 * whole
}
