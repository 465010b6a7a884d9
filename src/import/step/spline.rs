//! B-splines in all their spellings (ISO 10303-42, 4.4.37 to 4.4.45 and 4.5.36 to 4.5.44): with knots, uniform,
//! quasi-uniform or Bézier, rational or not, as one keyword or as a complex entity.

use super::args::{Args, Value};
use super::error::{StepError, bad};
use super::file::Entity;
use super::kinds::Kind;
use super::place::Shapes;
use crate::geometry::{MAX_DEGREE, NurbsCurve, NurbsSurface};
use glam::{DVec3, DVec4};

/// How the knots are given.
#[derive(Clone, Copy, PartialEq)]
enum Spacing {
    Written,
    Uniform,
    QuasiUniform,
    Bezier,
}

/// A B-spline's parameters, wherever the entity has them.
struct Spelling<'a> {
    /// From the degree on.
    base: Args<'a>,
    /// From the multiplicities on.
    knots: Option<Args<'a>>,
    weights: Option<Args<'a>>,
    spacing: Spacing,
}

/// The parameters of a curve (`directions` 1) or surface (2); `None` where the entity is no B-spline.
fn spelling<'a>(entity: &Entity<'a>, directions: usize) -> Option<Spelling<'a>> {
    let spacing_of = |kind| match kind {
        Kind::UniformCurve | Kind::UniformSurface => Some(Spacing::Uniform),
        Kind::QuasiUniformCurve | Kind::QuasiUniformSurface => Some(Spacing::QuasiUniform),
        Kind::BezierCurve | Kind::BezierSurface => Some(Spacing::Bezier),
        Kind::BSplineCurveWithKnots | Kind::BSplineSurfaceWithKnots => Some(Spacing::Written),
        _ => None,
    };
    let [base_kind, knots_kind, rational] = if directions == 1 {
        [Kind::BSplineCurve, Kind::BSplineCurveWithKnots, Kind::RationalBSplineCurve]
    } else {
        [Kind::BSplineSurface, Kind::BSplineSurfaceWithKnots, Kind::RationalBSplineSurface]
    };
    // Degree, points, form, closed, self-intersecting; surfaces have two degrees and two closed.
    let own = 3 + 2 * directions;
    if entity.kind == Kind::Complex {
        let parts = entity.parts();
        let of = |kind| parts.iter().find(|(k, _)| *k == kind).map(|(_, args)| args.clone());
        let spacing = parts.iter().find_map(|&(kind, _)| spacing_of(kind));
        return Some(Spelling {
            base: of(base_kind)?,
            knots: of(knots_kind),
            weights: of(rational),
            spacing: spacing.unwrap_or(Spacing::QuasiUniform),
        });
    }
    let is_spline = spacing_of(entity.kind).is_some() || [base_kind, rational].contains(&entity.kind);
    let base = is_spline.then(|| entity.args().ok())??.skip(1);
    let behind = || base.clone().skip(own);
    match spacing_of(entity.kind) {
        Some(spacing) => {
            let knots = (spacing == Spacing::Written).then(behind);
            Some(Spelling { base, knots, weights: None, spacing })
        }
        None if entity.kind == rational => {
            Some(Spelling { weights: Some(behind()), base, knots: None, spacing: Spacing::QuasiUniform })
        }
        None if entity.kind == base_kind => {
            Some(Spelling { base, knots: None, weights: None, spacing: Spacing::QuasiUniform })
        }
        None => None,
    }
}

impl Shapes<'_, '_> {
    /// A B-spline curve; `None` for another kind of entity.
    pub fn spline_curve(&self, entity: &Entity) -> Option<Result<NurbsCurve, StepError>> {
        spelling(entity, 1).map(|spelling| self.curve_of(entity, spelling))
    }

    fn curve_of(&self, entity: &Entity, mut spelling: Spelling) -> Result<NurbsCurve, StepError> {
        let degree = spelling.base.whole()?;
        let ids = spelling.base.references()?;
        let weights = spelling.weights.map(|mut w| w.numbers()).transpose()?;
        let points = weighted(entity.id, self.points(&ids)?, weights)?;
        let multiplicities = spelling.knots.as_mut().map(Args::numbers).transpose()?;
        let values = spelling.knots.as_mut().map(Args::numbers).transpose()?;
        let knots = knots(entity.id, spelling.spacing, degree, points.len(), multiplicities.zip(values))?;
        Ok(NurbsCurve::new(&format!("#{}", entity.id), degree, knots, points)?)
    }

    /// A B-spline surface; `None` for another kind of entity.
    pub fn spline_surface(&self, entity: &Entity) -> Option<Result<NurbsSurface, StepError>> {
        spelling(entity, 2).map(|spelling| self.surface_of(entity, spelling))
    }

    fn surface_of(&self, entity: &Entity, mut spelling: Spelling) -> Result<NurbsSurface, StepError> {
        let id = entity.id;
        let degree = [spelling.base.whole()?, spelling.base.whole()?];
        let rows = spelling.base.list()?;
        let mut points = Vec::new();
        let mut counts = [0, 0];
        for row in rows {
            let Value::List(row) = row else { return bad(id, "control points that are no list of lists") };
            let before = points.len();
            for value in row {
                let Value::Reference(point) = value else { return bad(id, "a control point that is no reference") };
                points.push(self.point(point)?);
            }
            if counts[0] > 0 && points.len() - before != counts[1] {
                return bad(id, "rows of control points that differ in length");
            }
            counts = [counts[0] + 1, points.len() - before];
        }
        let weights = spelling.weights.map(|mut w| table(&mut w, id)).transpose()?;
        let points = weighted(id, points, weights)?;
        let mut lists = || spelling.knots.as_mut().map(Args::numbers).transpose();
        let multiplicities = [lists()?, lists()?];
        let values = [lists()?, lists()?];
        let [mu, mv] = multiplicities;
        let [ku, kv] = values;
        let knots = [
            knots(id, spelling.spacing, degree[0], counts[0], mu.zip(ku))?,
            knots(id, spelling.spacing, degree[1], counts[1], mv.zip(kv))?,
        ];
        Ok(NurbsSurface::new(&format!("#{id}"), degree, counts, knots, points)?)
    }
}

/// The numbers of a list of lists, row by row.
fn table(args: &mut Args, id: u32) -> Result<Vec<f64>, StepError> {
    let mut numbers = Vec::new();
    for row in args.list()? {
        let Value::List(mut row) = row else { return bad(id, "weights that are no list of lists") };
        while let Some(number) = row.optional_number()? {
            numbers.push(number);
        }
    }
    Ok(numbers)
}

/// Homogeneous points.
fn weighted(id: u32, points: Vec<DVec3>, weights: Option<Vec<f64>>) -> Result<Vec<DVec4>, StepError> {
    let Some(weights) = weights else { return Ok(points.into_iter().map(|p| p.extend(1.0)).collect()) };
    if weights.len() != points.len() {
        return bad(id, format!("{} weights for {} control points", weights.len(), points.len()));
    }
    Ok(points.into_iter().zip(weights).map(|(p, w)| (p * w).extend(w)).collect())
}

/// The knot vector for `count` control points.
fn knots(
    id: u32,
    spacing: Spacing,
    degree: usize,
    count: usize,
    written: Option<(Vec<f64>, Vec<f64>)>,
) -> Result<Vec<f64>, StepError> {
    if degree == 0 || degree > MAX_DEGREE {
        return bad(id, format!("degree {degree} is outside 1 to {MAX_DEGREE}"));
    }
    if count <= degree {
        return bad(id, format!("{count} control points are too few for degree {degree}"));
    }
    let expected = count + degree + 1;
    let inner = count - degree;
    match (spacing, written) {
        (Spacing::Written, Some((multiplicities, values))) => expand(id, &multiplicities, &values, expected),
        (Spacing::Uniform, _) => Ok((0..expected).map(|k| k as f64 - degree as f64).collect()),
        (Spacing::Bezier, _) if !(count - 1).is_multiple_of(degree) => {
            bad(id, format!("{count} control points don't make Bézier pieces of degree {degree}"))
        }
        (Spacing::Bezier, _) => {
            let knot = |k: usize| k.saturating_sub(1).min(expected - 3) / degree;
            Ok((0..expected).map(|k| knot(k) as f64).collect())
        }
        _ => Ok((0..expected).map(|k| k.saturating_sub(degree).min(inner) as f64).collect()),
    }
}

/// Each value as often as it counts.
fn expand(id: u32, multiplicities: &[f64], values: &[f64], expected: usize) -> Result<Vec<f64>, StepError> {
    if multiplicities.len() != values.len() {
        return bad(id, format!("{} multiplicities for {} knots", multiplicities.len(), values.len()));
    }
    let mut knots = Vec::with_capacity(expected);
    for (&times, &value) in multiplicities.iter().zip(values) {
        if !(1.0..=expected as f64).contains(&times) || knots.len() + times as usize > expected {
            return bad(id, format!("the multiplicities don't add up to the {expected} knots needed"));
        }
        knots.extend(std::iter::repeat_n(value, times as usize));
    }
    Ok(knots)
}
