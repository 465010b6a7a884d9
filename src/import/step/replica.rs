//! Copies of curves and surfaces (ISO 10303-42, `curve_replica` and `surface_replica`): moved, scaled, mirrored. They are
//! of the same kind as what they copy, and have its parameters.

use super::args::Args;
use super::curve::Curve;
use super::error::{StepError, bad};
use super::place::Shapes;
use super::surface::Basis;
use crate::geometry::exact::Frame;
use crate::geometry::{CurveForm, CurveSpan, GeometryError, NurbsCurve, NurbsSurface, SurfaceForm};
use glam::{DAffine3, DVec3, DVec4};

/// A map that keeps angles.
pub(super) struct Similarity {
    map: DAffine3,
    /// A length is so much longer after it.
    scale: f64,
    mirrors: bool,
}

/// A surface's copy in our form.
struct Copy {
    form: SurfaceForm,
    /// How much greater a parameter of the copy's form is at the same point.
    factors: [f64; 2],
}

impl Shapes<'_, '_> {
    pub fn similarity(&self, id: u32) -> Result<Similarity, StepError> {
        let map = self.map(id)?;
        let volume = map.matrix3.determinant();
        let scale = volume.abs().cbrt();
        if !(scale > 0.0 && scale.is_finite()) {
            return bad(id, "a transformation that can't be inverted");
        }
        Ok(Similarity { map, scale, mirrors: volume < 0.0 })
    }

    pub fn surface_replica(&self, id: u32, mut args: Args, depth: u8) -> Result<Basis, StepError> {
        let mut basis = self.surface_at(args.reference()?, depth + 1)?;
        let similarity = self.similarity(args.reference()?)?;
        if basis.boundaries.is_some() {
            return bad(id, "a copy of a surface that is bounded by curves");
        }
        let Copy { form, factors } = similarity.surface(&basis.form)?;
        let ordered = |[a, b]: [f64; 2]| if a <= b { [a, b] } else { [b, a] };
        basis.form = form;
        basis.domain = basis.domain.map(|d| [0, 1].map(|axis| ordered(d[axis].map(|t| t * factors[axis]))));
        basis.scale = [0, 1].map(|axis| basis.scale[axis] * factors[axis]);
        basis.flipped ^= factors[0] * factors[1] < 0.0;
        basis.ids = vec![id];
        Ok(basis)
    }
}

impl Similarity {
    fn point(&self, p: DVec3) -> DVec3 {
        self.map.transform_point3(p)
    }

    fn vector(&self, v: DVec3) -> DVec3 {
        self.map.transform_vector3(v)
    }

    fn homogeneous(&self, points: &[DVec4]) -> Vec<DVec4> {
        points.iter().map(|p| (self.map.matrix3 * p.truncate() + self.map.translation * p.w).extend(p.w)).collect()
    }

    /// The image of x and y; the third axis is right-handed again, so that it is the mirrored one where this mirrors.
    fn frame(&self, frame: &Frame) -> Frame {
        let [x, y] = [frame.x, frame.y].map(|axis| self.vector(axis) / self.scale);
        Frame { origin: self.point(frame.origin), x, y, z: x.cross(y) }
    }

    fn form(&self, form: &CurveForm) -> Result<CurveForm, GeometryError> {
        let radii = |radii: [f64; 2]| radii.map(|r| r * self.scale);
        Ok(match form {
            CurveForm::Line { origin, direction } => {
                CurveForm::Line { origin: self.point(*origin), direction: self.vector(*direction) }
            }
            CurveForm::Ellipse { frame, radii: r } => CurveForm::Ellipse { frame: self.frame(frame), radii: radii(*r) },
            CurveForm::Parabola { frame, focal } => {
                CurveForm::Parabola { frame: self.frame(frame), focal: focal * self.scale }
            }
            CurveForm::Hyperbola { frame, radii: r } => {
                CurveForm::Hyperbola { frame: self.frame(frame), radii: radii(*r) }
            }
            CurveForm::Nurbs(curve) => {
                let points = self.homogeneous(curve.points());
                CurveForm::Nurbs(NurbsCurve::new("copy", curve.degree(), curve.knots().to_vec(), points)?)
            }
        })
    }

    fn span(&self, span: &CurveSpan) -> Result<CurveSpan, GeometryError> {
        Ok(CurveSpan { curve: self.form(&span.curve)?, range: span.range })
    }

    pub fn curve(&self, curve: &Curve) -> Result<Curve, StepError> {
        Ok(match curve {
            Curve::Whole(form) => Curve::Whole(self.form(form)?),
            Curve::Pieces(spans) => Curve::Pieces(spans.iter().map(|span| self.span(span)).collect::<Result<_, _>>()?),
        })
    }

    /// Heights and latitudes are counted along the frame's z axis: where that was mirrored they change their sign.
    fn surface(&self, form: &SurfaceForm) -> Result<Copy, GeometryError> {
        let k = self.scale;
        let side = if self.mirrors { -1.0 } else { 1.0 };
        let copy = |form, factors| Ok(Copy { form, factors });
        match form {
            SurfaceForm::Plane(frame) => copy(SurfaceForm::Plane(self.frame(frame)), [k; 2]),
            SurfaceForm::Cylinder { frame, radius } => {
                copy(SurfaceForm::Cylinder { frame: self.frame(frame), radius: radius * k }, [1.0, side * k])
            }
            SurfaceForm::Cone { frame, radius, half_angle } => {
                let (frame, radius, half_angle) = (self.frame(frame), radius * k, side * half_angle);
                copy(SurfaceForm::Cone { frame, radius, half_angle }, [1.0, side * k])
            }
            SurfaceForm::Sphere { frame, radius } => {
                copy(SurfaceForm::Sphere { frame: self.frame(frame), radius: radius * k }, [1.0, side])
            }
            SurfaceForm::Torus { frame, major, minor } => {
                let (frame, major, minor) = (self.frame(frame), major * k, minor * k);
                copy(SurfaceForm::Torus { frame, major, minor }, [1.0, side])
            }
            SurfaceForm::Extrusion { profile, direction } => {
                let (profile, direction) = (self.span(profile)?, self.vector(*direction));
                copy(SurfaceForm::Extrusion { profile, direction }, [1.0; 2])
            }
            // A mirrored turn is one about the opposite of the mirrored axis, which is what the frame has.
            SurfaceForm::Revolution { profile, frame } => {
                copy(SurfaceForm::Revolution { profile: self.span(profile)?, frame: self.frame(frame) }, [1.0; 2])
            }
            SurfaceForm::Offset { base, distance } => {
                let Copy { form, factors } = self.surface(base)?;
                // The normal is mirrored too, unless the parameters' order made up for it.
                let kept = (factors[0] * factors[1] < 0.0) == self.mirrors;
                let distance = if kept { distance * k } else { -distance * k };
                copy(SurfaceForm::Offset { base: Box::new(form), distance }, factors)
            }
            SurfaceForm::Nurbs(surface) => {
                let knots = surface.knots().each_ref().map(|knots| knots.values().to_vec());
                let points = self.homogeneous(surface.points());
                copy(
                    SurfaceForm::Nurbs(NurbsSurface::new("copy", surface.degree(), surface.counts(), knots, points)?),
                    [1.0; 2],
                )
            }
        }
    }
}
