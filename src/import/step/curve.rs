//! Curves (ISO 10303-42, 4.4).

use super::args::{Args, Value};
use super::error::{StepError, bad};
use super::file::Entity;
use super::invert::End;
use super::kinds::Kind;
use super::place::Shapes;
use crate::geometry::{CurveForm, CurveSpan, NurbsCurve};
use glam::DVec3;

/// A curve as the file has it.
#[derive(Clone, Debug)]
pub(super) enum Curve {
    /// All of it: a line without ends, a full circle, a B-spline over its domain.
    Whole(CurveForm),
    /// Joined end to end.
    Pieces(Vec<CurveSpan>),
}

impl Shapes<'_, '_> {
    pub fn curve(&self, id: u32) -> Result<Curve, StepError> {
        self.curve_at(id, 0)
    }

    /// A curve at some depth of a nest of curves and surfaces.
    pub fn curve_at(&self, id: u32, depth: u8) -> Result<Curve, StepError> {
        self.step_into(id, depth)?;
        let entity = self.file.get(id)?;
        if let Some(curve) = self.spline_curve(&entity) {
            return Ok(Curve::Whole(CurveForm::Nurbs(curve?)));
        }
        let mut args = match entity.kind {
            Kind::Complex => return self.complex_curve(&entity, depth),
            _ => entity.args()?.skip(1),
        };
        Ok(match entity.kind {
            Kind::Line => {
                let origin = self.point(args.reference()?)?;
                Curve::Whole(CurveForm::Line { origin, direction: self.vector(args.reference()?)? })
            }
            Kind::Circle | Kind::Ellipse | Kind::Parabola | Kind::Hyperbola => Curve::Whole(self.conic(&entity, args)?),
            Kind::Polyline => self.polyline(id, args.references()?)?,
            Kind::TrimmedCurve => self.trimmed(id, args, depth)?,
            Kind::CompositeCurve | Kind::CompositeCurveOnSurface | Kind::BoundaryCurve | Kind::OuterBoundaryCurve => {
                self.composite(args.references()?, depth)?
            }
            Kind::SurfaceCurve | Kind::SeamCurve | Kind::IntersectionCurve | Kind::BoundedSurfaceCurve => {
                self.curve_at(args.reference()?, depth + 1)?
            }
            Kind::OffsetCurve3d | Kind::OffsetCurve2d => {
                let basis = self.curve_at(args.reference()?, depth + 1)?;
                let distance = args.number()? * self.units.length;
                let flat = entity.kind == Kind::OffsetCurve2d;
                let axis = if flat { DVec3::Z } else { self.direction(args.skip(1).reference()?)? };
                self.offset_curve(id, basis, distance, axis)?
            }
            Kind::Pcurve => self.curve_on_surface(id, depth + 1)?,
            Kind::CurveReplica => {
                let parent = self.curve_at(args.reference()?, depth + 1)?;
                self.similarity(args.reference()?)?.curve(&parent)?
            }
            _ => return Err(entity.is_not("a curve that is read here")),
        })
    }

    /// Surface curves may come with all their supertypes.
    fn complex_curve(&self, entity: &Entity, depth: u8) -> Result<Curve, StepError> {
        if let Some(mut args) = entity.part(Kind::SurfaceCurve) {
            return self.curve_at(args.reference()?, depth + 1);
        }
        if let Some(mut args) = entity.part(Kind::CompositeCurve) {
            return self.composite(args.references()?, depth);
        }
        Err(entity.is_not("a curve that is read here"))
    }

    fn conic(&self, entity: &Entity, mut args: Args) -> Result<CurveForm, StepError> {
        let frame = self.frame(args.reference()?)?;
        let mut length = || {
            let value = args.number()? * self.units.length;
            if value > 0.0 { Ok(value) } else { bad(entity.id, format!("a radius of {value} mm")) }
        };
        Ok(match entity.kind {
            Kind::Circle => {
                let radius = length()?;
                CurveForm::Ellipse { frame, radii: [radius, radius] }
            }
            Kind::Ellipse => CurveForm::Ellipse { frame, radii: [length()?, length()?] },
            Kind::Parabola => CurveForm::Parabola { frame, focal: length()? },
            _ => CurveForm::Hyperbola { frame, radii: [length()?, length()?] },
        })
    }

    /// Degree 1, one knot a point.
    fn polyline(&self, id: u32, points: Vec<u32>) -> Result<Curve, StepError> {
        let points: Vec<_> = self.points(&points)?.into_iter().map(|p| p.extend(1.0)).collect();
        let last = points.len().saturating_sub(1);
        let knots = (0..points.len() + 2).map(|k| k.saturating_sub(1).min(last) as f64).collect();
        Ok(Curve::Whole(CurveForm::Nurbs(NurbsCurve::new(&format!("#{id}"), 1, knots, points)?)))
    }

    fn trimmed(&self, id: u32, mut args: Args, depth: u8) -> Result<Curve, StepError> {
        let parent = args.reference()?;
        let basis = self.curve_at(parent, depth + 1)?;
        let nested = self.file.get(parent)?.kind == Kind::TrimmedCurve;
        let ends = [args.list()?, args.list()?];
        let forward = args.flag()?;
        let by_point = args.enumeration() == b"CARTESIAN";
        let [start, end] = ends.map(|end| self.trim(&basis, nested, end, by_point));
        let (Some(start), Some(end)) = (start?, end?) else { return bad(id, "a trim without point or parameter") };
        Ok(Curve::Pieces(basis.between(start, end, forward, self.units.tolerance)))
    }

    /// One end of a trimmed curve, as its point or its parameter; what the file prefers where it has both. `nested`: the
    /// basis is a trimmed curve, which has the parameters of its own basis.
    fn trim(&self, basis: &Curve, nested: bool, select: Args, by_point: bool) -> Result<Option<End>, StepError> {
        let (mut point, mut parameter) = (None, None);
        for value in select {
            match value {
                Value::Reference(id) => point = Some(End::Point(self.point(id)?)),
                Value::Typed(mut inner) => parameter = Some(inner.number()?),
                _ => {}
            }
        }
        let parameter = parameter.and_then(|t| match basis {
            Curve::Whole(form) => Some(End::Parameter(t * self.parameter_scale(form))),
            Curve::Pieces(spans) => self.point_at(spans, nested, t).map(End::Point),
        });
        Ok(if by_point { point.or(parameter) } else { parameter.or(point) })
    }

    /// What one of the file's parameters is in ours: those of conics that close are angles.
    pub fn parameter_scale(&self, form: &CurveForm) -> f64 {
        if matches!(form, CurveForm::Ellipse { .. }) { self.units.angle } else { 1.0 }
    }

    /// The point of joined pieces at a parameter of the file: a composite curve's runs from 0 on through those of its
    /// segments one after the other (ISO 10303-42, 4.4.30).
    fn point_at(&self, spans: &[CurveSpan], nested: bool, t: f64) -> Option<DVec3> {
        if let ([span], true) = (spans, nested) {
            return Some(span.curve.position(t * self.parameter_scale(&span.curve)));
        }
        let mut rest = t;
        for (k, span) in spans.iter().enumerate() {
            let [a, b] = span.range;
            let length = (b - a).abs() / self.parameter_scale(&span.curve);
            if rest <= length || k + 1 == spans.len() {
                let part = if length > 0.0 { (rest / length).clamp(0.0, 1.0) } else { 0.0 };
                return Some(span.curve.position(a + (b - a) * part));
            }
            rest -= length;
        }
        None
    }

    fn composite(&self, segments: Vec<u32>, depth: u8) -> Result<Curve, StepError> {
        let mut spans = Vec::new();
        for segment in segments {
            spans.extend(self.segment(segment, depth)?);
        }
        Ok(Curve::Pieces(spans))
    }

    /// A segment's spans in the composite's direction.
    pub fn segment(&self, id: u32, depth: u8) -> Result<Vec<CurveSpan>, StepError> {
        let entity = self.file.get(id)?;
        if !matches!(entity.kind, Kind::CompositeCurveSegment | Kind::ReparametrisedCompositeCurveSegment) {
            return Err(entity.is_not("a segment of a curve"));
        }
        let mut args = entity.args()?.skip(1);
        let forward = args.flag()?;
        let parent = args.reference()?;
        let Some(spans) = self.curve_at(parent, depth + 1)?.spans() else {
            return bad(parent, "a segment without ends");
        };
        Ok(if forward { spans } else { backward(spans) })
    }
}

impl Curve {
    /// All of a curve that has ends, or is closed.
    pub fn spans(&self) -> Option<Vec<CurveSpan>> {
        match self {
            Self::Pieces(spans) => Some(spans.clone()),
            Self::Whole(form) => {
                let range = whole_range(form)?;
                Some(vec![CurveSpan { curve: form.clone(), range }])
            }
        }
    }
}

/// The range of a curve that has ends or is closed.
pub(super) fn whole_range(form: &CurveForm) -> Option<[f64; 2]> {
    match form {
        CurveForm::Ellipse { .. } => Some([0.0, std::f64::consts::TAU]),
        CurveForm::Nurbs(curve) => Some(curve.domain()),
        CurveForm::Line { .. } | CurveForm::Parabola { .. } | CurveForm::Hyperbola { .. } => None,
    }
}

/// The same spans from their end to their start.
pub(super) fn backward(spans: Vec<CurveSpan>) -> Vec<CurveSpan> {
    spans.into_iter().rev().map(|s| CurveSpan { range: [s.range[1], s.range[0]], ..s }).collect()
}
