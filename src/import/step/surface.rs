//! Surfaces (ISO 10303-42, 4.5).

use super::args::Args;
use super::curve::{Curve, whole_range};
use super::error::{StepError, bad};
use super::file::Entity;
use super::join::joined;
use super::kinds::Kind;
use super::place::Shapes;
use crate::geometry::exact::Frame;
use crate::geometry::{CurveForm, CurveSpan, SurfaceForm};
use crate::model::SurfaceKind;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Bounds in the surface's own parameters, where it has some.
type Domain = Option<[[f64; 2]; 2]>;

/// A surface as the file has it.
pub(super) struct Basis {
    pub form: SurfaceForm,
    pub kind: SurfaceKind,
    /// Bounds in its parameters, where it has some.
    pub domain: Domain,
    /// The file's normal is the other one than `S_u x S_v`.
    pub flipped: bool,
    /// The entity itself, and those that it trims: what pcurves lie on.
    pub ids: Vec<u32>,
    /// Boundary curves of a curve-bounded surface, and whether the basis' own boundary counts too.
    pub boundaries: Option<(Vec<u32>, bool)>,
    /// What a parameter of the file's in u and v is in ours.
    pub scale: [f64; 2],
}

impl Shapes<'_, '_> {
    pub fn surface(&self, id: u32) -> Result<Basis, StepError> {
        self.surface_at(id, 0)
    }

    /// A surface at some depth of a nest of curves and surfaces.
    pub fn surface_at(&self, id: u32, depth: u8) -> Result<Basis, StepError> {
        self.step_into(id, depth)?;
        let entity = self.file.get(id)?;
        let basis = |form, kind, scale| Basis {
            form,
            kind,
            domain: None,
            flipped: false,
            ids: vec![id],
            boundaries: None,
            scale,
        };
        if let Some(surface) = self.spline_surface(&entity) {
            return Ok(basis(SurfaceForm::Nurbs(surface?), SurfaceKind::BSpline, [1.0; 2]));
        }
        let args = entity.args()?.skip(1);
        let [length, angle] = [self.units.length, self.units.angle];
        Ok(match entity.kind {
            Kind::Plane => basis(SurfaceForm::Plane(self.placed(args)?.0), SurfaceKind::Plane, [length; 2]),
            Kind::CylindricalSurface | Kind::ConicalSurface => {
                let (form, kind) = self.round(&entity, args)?;
                basis(form, kind, [angle, length])
            }
            Kind::SphericalSurface => {
                let (frame, mut args) = self.placed(args)?;
                let radius = self.radius(id, &mut args)?;
                basis(SurfaceForm::Sphere { frame, radius }, SurfaceKind::Sphere, [angle; 2])
            }
            Kind::ToroidalSurface | Kind::DegenerateToroidalSurface => {
                let (form, domain) = self.torus(&entity, args)?;
                Basis { domain, ..basis(form, SurfaceKind::Torus, [angle; 2]) }
            }
            Kind::SurfaceOfLinearExtrusion => {
                let (form, scale) = self.extrusion(args, depth)?;
                basis(form, SurfaceKind::Extrusion, [scale, 1.0])
            }
            Kind::SurfaceOfRevolution => {
                let (form, scale) = self.revolution(args, depth)?;
                basis(form, SurfaceKind::Revolution, [angle, scale])
            }
            Kind::OffsetSurface => self.offset_surface(id, args, depth)?,
            Kind::RectangularTrimmedSurface => self.trimmed_surface(id, args, depth)?,
            Kind::SurfaceReplica => self.surface_replica(id, args, depth)?,
            Kind::CurveBoundedSurface => self.bounded_surface(id, args, depth)?,
            _ => return Err(entity.is_not("a surface that is read here")),
        })
    }

    /// The placement that comes first, and what follows.
    fn placed<'b>(&self, mut args: Args<'b>) -> Result<(Frame, Args<'b>), StepError> {
        let frame = self.frame(args.reference()?)?;
        Ok((frame, args))
    }

    fn radius(&self, id: u32, args: &mut Args) -> Result<f64, StepError> {
        let radius = args.number()? * self.units.length;
        if radius > 0.0 { Ok(radius) } else { bad(id, format!("a radius of {radius} mm")) }
    }

    fn round(&self, entity: &Entity, args: Args) -> Result<(SurfaceForm, SurfaceKind), StepError> {
        let (frame, mut args) = self.placed(args)?;
        if entity.kind == Kind::CylindricalSurface {
            let radius = self.radius(entity.id, &mut args)?;
            return Ok((SurfaceForm::Cylinder { frame, radius }, SurfaceKind::Cylinder));
        }
        // The radius may be 0: the placement is then at the apex.
        let radius = args.number()? * self.units.length;
        let half_angle = args.number()? * self.units.angle;
        if radius < 0.0 || half_angle.abs() >= FRAC_PI_2 {
            return bad(entity.id, format!("a cone of radius {radius} mm and half angle {half_angle}"));
        }
        Ok((SurfaceForm::Cone { frame, radius, half_angle }, SurfaceKind::Cone))
    }

    /// A degenerate one has the part of its tube that the file selects: the outer, apple, or the inner, lemon.
    fn torus(&self, entity: &Entity, args: Args) -> Result<(SurfaceForm, Domain), StepError> {
        let (frame, mut args) = self.placed(args)?;
        let major = args.number()? * self.units.length;
        let minor = self.radius(entity.id, &mut args)?;
        if major < 0.0 {
            return bad(entity.id, format!("a torus of radius {major} mm"));
        }
        let mut domain = None;
        if entity.kind == Kind::DegenerateToroidalSurface && minor > major {
            let outer = args.flag()?;
            let crossing = (-major / minor).acos();
            let v = if outer { [-crossing, crossing] } else { [crossing, TAU - crossing] };
            domain = Some([[0.0, TAU], v]);
        }
        Ok((SurfaceForm::Torus { frame, major, minor }, domain))
    }

    /// A swept curve as one span, and what one of its parameters is in ours.
    fn profile(&self, id: u32, depth: u8) -> Result<(CurveSpan, f64), StepError> {
        let curve = match self.curve_at(id, depth + 1)? {
            Curve::Whole(curve) => curve,
            Curve::Pieces(mut spans) if spans.len() == 1 => {
                let scale = self.parameter_scale(&spans[0].curve);
                return Ok((spans.remove(0), scale));
            }
            Curve::Pieces(spans) => CurveForm::Nurbs(joined(id, &spans)?),
        };
        let scale = self.parameter_scale(&curve);
        let range = whole_range(&curve).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        Ok((CurveSpan { curve, range }, scale))
    }

    fn extrusion(&self, mut args: Args, depth: u8) -> Result<(SurfaceForm, f64), StepError> {
        let (profile, scale) = self.profile(args.reference()?, depth)?;
        let direction = self.vector(args.reference()?)?;
        Ok((SurfaceForm::Extrusion { profile, direction }, scale))
    }

    fn revolution(&self, mut args: Args, depth: u8) -> Result<(SurfaceForm, f64), StepError> {
        let (profile, scale) = self.profile(args.reference()?, depth)?;
        let frame = self.frame(args.reference()?)?;
        Ok((SurfaceForm::Revolution { profile, frame }, scale))
    }

    /// Of simple surfaces it is one of them again, with the same parameters.
    fn offset_surface(&self, id: u32, mut args: Args, depth: u8) -> Result<Basis, StepError> {
        let mut basis = self.surface_at(args.reference()?, depth + 1)?;
        let sign = if basis.flipped { -1.0 } else { 1.0 };
        let distance = sign * args.number()? * self.units.length;
        let moved = |f: &Frame, by: f64| Frame { origin: f.origin + f.z * by, ..*f };
        let positive = |r: f64| (r > 0.0).then_some(r);
        let exact = match &basis.form {
            SurfaceForm::Plane(frame) => Some(SurfaceForm::Plane(moved(frame, distance))),
            SurfaceForm::Cylinder { frame, radius } => {
                positive(radius + distance).map(|radius| SurfaceForm::Cylinder { frame: *frame, radius })
            }
            SurfaceForm::Sphere { frame, radius } => {
                positive(radius + distance).map(|radius| SurfaceForm::Sphere { frame: *frame, radius })
            }
            SurfaceForm::Torus { frame, major, minor } => {
                positive(minor + distance).map(|minor| SurfaceForm::Torus { frame: *frame, major: *major, minor })
            }
            SurfaceForm::Cone { frame, radius, half_angle } => {
                let (sin, cos) = half_angle.sin_cos();
                let radius = radius + distance * cos;
                let frame = moved(frame, -distance * sin);
                (radius >= 0.0).then_some(SurfaceForm::Cone { frame, radius, half_angle: *half_angle })
            }
            _ => None,
        };
        basis.form = exact.unwrap_or_else(|| SurfaceForm::Offset { base: Box::new(basis.form), distance });
        if matches!(basis.form, SurfaceForm::Offset { .. }) {
            basis.kind = SurfaceKind::Offset;
        }
        basis.ids = vec![id];
        Ok(basis)
    }

    fn trimmed_surface(&self, id: u32, mut args: Args, depth: u8) -> Result<Basis, StepError> {
        let mut basis = self.surface_at(args.reference()?, depth + 1)?;
        let u = [args.number()?, args.number()?].map(|t| t * basis.scale[0]);
        let v = [args.number()?, args.number()?].map(|t| t * basis.scale[1]);
        let senses = [args.flag()?, args.flag()?];
        let (periods, limits) = (basis.form.periods(self.units.tolerance), basis.form.limits());
        // A parameter that runs against ours is passed through the other way.
        let upward = [0, 1].map(|axis| senses[axis] == (basis.scale[axis] > 0.0));
        basis.domain = Some([within(u, upward[0], periods[0], limits[0]), within(v, upward[1], periods[1], limits[1])]);
        if basis.domain.is_some_and(|d| d.iter().any(|[a, b]| a >= b)) {
            return bad(id, "trimmed to nothing");
        }
        basis.flipped ^= senses[0] != senses[1];
        basis.ids.push(id);
        Ok(basis)
    }

    fn bounded_surface(&self, id: u32, mut args: Args, depth: u8) -> Result<Basis, StepError> {
        let mut basis = self.surface_at(args.reference()?, depth + 1)?;
        basis.boundaries = Some((args.references()?, args.flag()?));
        basis.ids.push(id);
        Ok(basis)
    }
}

/// The interval between two bounds, from the first to the second where `sense` says so: of a parameter that closes at
/// most one turn, of another what its limits leave.
fn within([from, to]: [f64; 2], sense: bool, period: Option<f64>, [least, most]: [f64; 2]) -> [f64; 2] {
    let [low, high] = if sense { [from, to] } else { [to, from] };
    let Some(period) = period else { return [low.min(high).max(least), low.max(high).min(most)] };
    let length = (high - low).rem_euclid(period);
    let turn = length <= 1e-9 * period || high - low >= period;
    // Far from the first turn there are few digits left.
    let start = if low.abs() > 16.0 * period { low.rem_euclid(period) } else { low };
    [start, start + if turn { period } else { length }]
}
