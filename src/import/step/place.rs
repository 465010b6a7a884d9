//! Points, directions and placements.

use super::error::{StepError, bad};
use super::file::File;
use super::kinds::Kind;
use super::units::Units;
use crate::geometry::exact::Frame;
use crate::model::Warning;
use glam::{DAffine3, DMat3, DVec3};
use std::cell::{Cell, RefCell};
use std::fmt::Display;

/// Curves and surfaces of each other may not nest deeper.
pub(super) const MAX_DEPTH: u8 = 16;
/// Nor may one face be made of more of them: nests with branches grow like powers.
const MAX_STEPS: u32 = 1 << 17;

/// What happens while one face is read.
#[derive(Default)]
pub(super) struct Log {
    /// What was mended or approximated on the way.
    pub notes: RefCell<Vec<Warning>>,
    /// The face contradicts itself: its shell may not be closed, whatever the file says.
    pub doubtful: Cell<bool>,
    steps: Cell<u32>,
}

/// Reads geometry in the units of one context: millimetres and radians come out.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'f, 'a> {
    pub file: &'f File<'a>,
    pub units: Units,
    pub log: &'f Log,
}

impl<'f, 'a> Shapes<'f, 'a> {
    /// Keeps what was done to an entity for the model's warnings.
    pub fn note(&self, entity: u32, what: impl Display) {
        self.log.notes.borrow_mut().push(Warning { entity: Some(entity), message: format!("#{entity}: {what}") });
    }

    /// Counts curves and surfaces, and stops where they don't end.
    pub fn step_into(&self, id: u32, depth: u8) -> Result<(), StepError> {
        let steps = self.log.steps.get() + 1;
        self.log.steps.set(steps);
        if depth > MAX_DEPTH || steps > MAX_STEPS { Err(StepError::Depth(id)) } else { Ok(()) }
    }

    /// The same file with its numbers as they are, for what lies in a parameter plane.
    pub fn plain(self) -> Self {
        Self { units: Units { length: 1.0, angle: 1.0, ..self.units }, ..self }
    }

    /// The numbers of a point or a direction; those that are missing are 0.
    fn triple(&self, id: u32, kind: Kind, expected: &'static str) -> Result<DVec3, StepError> {
        if let Some(triple) = self.file.triple(id, kind) {
            return Ok(triple);
        }
        let mut list = self.file.args(id, kind, expected)?.skip(1).list()?;
        let mut number = || list.optional_number().map(|x| x.unwrap_or(0.0));
        Ok(DVec3::new(number()?, number()?, number()?))
    }

    /// A point.
    pub fn point(&self, id: u32) -> Result<DVec3, StepError> {
        Ok(self.triple(id, Kind::CartesianPoint, "a point")? * self.units.length)
    }

    pub fn points(&self, ids: &[u32]) -> Result<Vec<DVec3>, StepError> {
        ids.iter().map(|&id| self.point(id)).collect()
    }

    pub fn vertex(&self, id: u32) -> Result<DVec3, StepError> {
        let point = self.file.args(id, Kind::VertexPoint, "a vertex with a point")?.skip(1).reference()?;
        self.point(point)
    }

    /// A unit vector.
    pub fn direction(&self, id: u32) -> Result<DVec3, StepError> {
        let ratios = self.triple(id, Kind::Direction, "a direction")?;
        ratios.try_normalize().map_or_else(|| bad(id, "a direction without length"), Ok)
    }

    /// A direction with its length.
    pub fn vector(&self, id: u32) -> Result<DVec3, StepError> {
        let mut args = self.file.args(id, Kind::Vector, "a vector")?.skip(1);
        let direction = self.direction(args.reference()?)?;
        let magnitude = args.number()?;
        // Lines with vectors of length 0 exist; any length gives the same line.
        Ok(direction * (if magnitude == 0.0 { 1.0 } else { magnitude } * self.units.length))
    }

    fn optional_direction(&self, id: Option<u32>) -> Option<DVec3> {
        id.and_then(|id| self.direction(id).ok())
    }

    /// A placement of any kind: an axis with or without reference direction, or one in the plane.
    pub fn frame(&self, id: u32) -> Result<Frame, StepError> {
        let entity = self.file.get(id)?;
        let mut args = match entity.kind {
            Kind::Axis2Placement3d | Kind::Axis1Placement | Kind::Axis2Placement2d => entity.args()?.skip(1),
            _ => return Err(entity.is_not("a placement")),
        };
        let origin = self.point(args.reference()?)?;
        let first = self.optional_direction(args.optional_reference());
        let (axis, reference) = match entity.kind {
            Kind::Axis2Placement2d => (DVec3::Z, first),
            Kind::Axis1Placement => (first.unwrap_or(DVec3::Z), None),
            _ => (first.unwrap_or(DVec3::Z), self.optional_direction(args.optional_reference())),
        };
        let reference = reference.unwrap_or(if axis.x.abs() > 1.0 - 1e-9 { DVec3::Z } else { DVec3::X });
        Frame::new(origin, axis, reference).map_or_else(|| bad(id, "an axis without direction"), Ok)
    }

    /// A placement, or a transformation operator that may scale and mirror, as a map from its own coordinates.
    pub fn map(&self, id: u32) -> Result<DAffine3, StepError> {
        let entity = self.file.get(id)?;
        let (mut args, mut third) = match entity.kind {
            Kind::CartesianTransformation3d => {
                let args = entity.args()?;
                // Names of one or two supertypes come before the five attributes of its own.
                let names = args.clone().count().saturating_sub(5);
                (args.clone().skip(names), args.skip(names + 4))
            }
            Kind::Complex => {
                let [base, own] =
                    [Kind::CartesianTransformation, Kind::CartesianTransformation3d].map(|k| entity.part(k));
                base.zip(own).ok_or_else(|| entity.is_not("a transformation"))?
            }
            _ => return self.frame(id).map(|f| frame_map(&f)),
        };
        let [x, y] = [args.optional_reference(), args.optional_reference()].map(|d| self.optional_direction(d));
        let origin = self.point(args.reference()?)?;
        let scale = args.optional_number()?.unwrap_or(1.0);
        if scale == 0.0 {
            return bad(id, "a scale of 0");
        }
        let z = self.optional_direction(third.optional_reference());
        Ok(DAffine3::from_mat3_translation(operator_axes(x, y, z) * scale, origin))
    }
}

/// As ISO 10303-42's function `base_axis` has it: z as given, x next to it, of y only the side; a left-handed result
/// mirrors.
fn operator_axes(x: Option<DVec3>, y: Option<DVec3>, z: Option<DVec3>) -> DMat3 {
    let z = z.unwrap_or(DVec3::Z);
    let x = x.unwrap_or(if z.x.abs() > 1.0 - 1e-9 { DVec3::Y } else { DVec3::X });
    let x = (x - z * x.dot(z)).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
    let side = z.cross(x);
    let y = if y.is_some_and(|y| y.dot(side) < 0.0) { -side } else { side };
    DMat3::from_cols(x, y, z)
}

pub(super) fn frame_map(frame: &Frame) -> DAffine3 {
    DAffine3::from_mat3_translation(DMat3::from_cols(frame.x, frame.y, frame.z), frame.origin)
}
