//! Curves in the parameter plane of a surface.

use super::curve::{Curve, backward, whole_range};
use super::error::{StepError, bad};
use super::face::EdgeGeometry;
use super::join::{FIT_TOLERANCE, followed, of_pieces};
use super::kinds::Kind;
use super::place::Shapes;
use super::surface::Basis;
use crate::geometry::{CurveForm, CurvePiece, CurveSpan, NurbsCurve};
use crate::import::brep::{Bound, EdgeUse};
use glam::{DAffine3, DVec3};

impl Shapes<'_, '_> {
    /// The file's pcurves of an edge on this surface, with the edge's own parameters; those that can't be read are no
    /// loss, the edge itself is projected then.
    pub fn pcurves(&self, edge: &EdgeGeometry, spans: &[CurveSpan], basis: &Basis) -> Vec<Vec<CurveSpan>> {
        let full = match &edge.curve {
            Curve::Whole(curve) => whole_range(curve),
            Curve::Pieces(_) => None,
        };
        let on_surface = |&id: &u32| {
            let (surface, curve) = self.pcurve(id).ok()?;
            basis.ids.contains(&surface).then_some(())?;
            let own = self.plain().edge_geometry(curve, edge.forward).ok()?;
            let Curve::Whole(form) = own.curve else { return None };
            // A curve that runs the other way has other parameters.
            let form = scaled(form, basis.scale).filter(|_| own.forward == edge.forward)?;
            let ranges = spans.iter().map(|s| matching_range(&form, s.range.map(|t| t / edge.scale), full));
            ranges.map(|range| range.map(|range| CurveSpan { curve: form.clone(), range })).collect()
        };
        edge.associated.iter().filter_map(on_surface).collect()
    }

    /// A pcurve's surface, and its curve in the plane.
    fn pcurve(&self, id: u32) -> Result<(u32, u32), StepError> {
        let mut args = self.file.args(id, Kind::Pcurve, "a pcurve")?.skip(1);
        let (surface, definition) = (args.reference()?, args.reference()?);
        let mut items = self.file.args(definition, Kind::DefinitionalRepresentation, "a curve in a plane")?.skip(1);
        let curve = items.references()?.first().copied();
        curve.map_or_else(|| bad(definition, "a representation without items"), |curve| Ok((surface, curve)))
    }

    /// A pcurve's spans in our parameters.
    fn plane_spans(&self, curve: u32, basis: &Basis, depth: u8) -> Result<Vec<CurveSpan>, StepError> {
        let Some(spans) = self.plain().curve_at(curve, depth)?.spans() else {
            return bad(curve, "a pcurve without ends");
        };
        let spans = spans.into_iter().map(|span| {
            let Some(curve) = scaled(span.curve.clone(), basis.scale) else {
                // A conic that is stretched, as a B-spline over the span alone.
                let map = DAffine3::from_scale(factor(basis.scale));
                let curve = of_pieces(curve, &span.pieces(), &map)?;
                return Ok(CurveSpan { range: curve.domain(), curve: CurveForm::Nurbs(curve) });
            };
            Ok(CurveSpan { curve, range: span.range })
        });
        spans.collect()
    }

    /// A curve that only its image in a parameter plane gives: approximated in space.
    pub fn curve_on_surface(&self, id: u32, depth: u8) -> Result<Curve, StepError> {
        let (surface, curve) = self.pcurve(id)?;
        let basis = self.surface_at(surface, depth)?;
        let mut spans = Vec::new();
        for span in self.plane_spans(curve, &basis, depth)? {
            spans.push(self.lifted(id, &span, &basis)?);
        }
        self.note(id, format!("a curve of a parameter plane, approximated in space to {FIT_TOLERANCE:e} mm"));
        Ok(Curve::Pieces(spans))
    }

    /// The image in space of a span of the parameter plane.
    fn lifted(&self, id: u32, span: &CurveSpan, basis: &Basis) -> Result<CurveSpan, StepError> {
        let image = |t: f64| {
            let p = span.curve.position(t);
            basis.form.position(p.x, p.y)
        };
        let mut pieces: Vec<CurvePiece> = Vec::new();
        for part in span.breaks().windows(2) {
            pieces.extend(followed(id, [part[0], part[1]], &image)?);
        }
        let curve = of_pieces(id, &pieces, &DAffine3::IDENTITY)?;
        let range = curve.domain();
        Ok(CurveSpan { curve: CurveForm::Nurbs(curve), range })
    }

    /// The bounds of a curve-bounded surface.
    pub fn boundaries(&self, basis: &Basis) -> Result<Vec<Bound>, StepError> {
        let Some((curves, implicit_outer)) = &basis.boundaries else { return Ok(Vec::new()) };
        let mut bounds = Vec::new();
        for &curve in curves {
            let entity = self.file.get(curve)?;
            let mut edges = Vec::new();
            for segment in entity.args()?.skip(1).references()? {
                edges.extend(self.boundary_segment(segment, basis)?);
            }
            bounds.extend((!edges.is_empty()).then_some(Bound::Edges(edges)));
        }
        if *implicit_outer && !bounds.is_empty() {
            bounds.push(self.outline(basis)?);
        }
        Ok(bounds)
    }

    /// The edges of one segment; where it is a pcurve on this very surface, with that.
    fn boundary_segment(&self, id: u32, basis: &Basis) -> Result<Vec<EdgeUse>, StepError> {
        let spans = self.segment(id, 0)?;
        let entity = self.file.get(id)?;
        let mut args = entity.args()?.skip(1);
        let (forward, parent) = (args.flag()?, args.reference()?);
        let own = self.pcurve(parent).ok().filter(|(surface, _)| basis.ids.contains(surface));
        let plane = own.and_then(|(_, curve)| self.plane_spans(curve, basis, 0).ok());
        let plane = plane.map(|plane| if forward { plane } else { backward(plane) });
        let edge = |(k, span): (usize, CurveSpan)| {
            let pcurve = plane.as_ref().and_then(|p| p.get(k)).cloned();
            EdgeUse {
                edge: id,
                ends: span.ends(),
                spans: vec![span],
                pcurves: pcurve.into_iter().map(|p| vec![p]).collect(),
            }
        };
        Ok(spans.into_iter().enumerate().map(edge).collect())
    }

    /// The border of a surface's own parameters, counter-clockwise.
    fn outline(&self, basis: &Basis) -> Result<Bound, StepError> {
        let id = basis.ids.first().copied().unwrap_or_default();
        let [u, v] = basis.domain.unwrap_or_else(|| basis.form.limits());
        if !u.iter().chain(&v).all(|t| t.is_finite()) {
            return bad(id, "bounded by its own border, and has none");
        }
        let corners = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]].map(|[u, v]| DVec3::new(u, v, 0.0));
        let mut edges = Vec::new();
        for k in 0..4 {
            let (origin, end) = (corners[k], corners[(k + 1) % 4]);
            let line = CurveSpan { curve: CurveForm::Line { origin, direction: end - origin }, range: [0.0, 1.0] };
            let span = self.lifted(id, &line, basis)?;
            edges.push(EdgeUse { edge: id, ends: span.ends(), spans: vec![span], pcurves: vec![vec![line]] });
        }
        Ok(Bound::Edges(edges))
    }
}

/// The range of a pcurve that goes with a range of the edge: the same, or all of it for all of the edge's curve.
fn matching_range(form: &CurveForm, range: [f64; 2], full: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let CurveForm::Nurbs(curve) = form else { return Some(range) };
    let [a, b] = curve.domain();
    let slack = 1e-9 * (b - a);
    if range.iter().all(|t| (a - slack..=b + slack).contains(t)) {
        return Some(range.map(|t| t.clamp(a, b)));
    }
    let all = |[c, d]: [f64; 2]| if range == [c, d] { Some([a, b]) } else { (range == [d, c]).then_some([b, a]) };
    full.and_then(all)
}

fn factor([u, v]: [f64; 2]) -> DVec3 {
    DVec3::new(u, v, 1.0)
}

/// A curve of the parameter plane with u and v in our units; `None` for conics that are none any more.
fn scaled(form: CurveForm, scale: [f64; 2]) -> Option<CurveForm> {
    if scale == [1.0; 2] {
        return Some(form);
    }
    let factor = factor(scale);
    match form {
        CurveForm::Line { origin, direction } => {
            Some(CurveForm::Line { origin: origin * factor, direction: direction * factor })
        }
        CurveForm::Nurbs(curve) => {
            let points = curve.points().iter().map(|p| *p * factor.extend(1.0)).collect();
            NurbsCurve::new("", curve.degree(), curve.knots().to_vec(), points).ok().map(CurveForm::Nurbs)
        }
        _ => None,
    }
}
