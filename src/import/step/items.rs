//! From the items of a representation to the faces that they are made of.

use super::error::StepError;
use super::file::{Entity, File};
use super::kinds::Kind;
use super::styles::Styles;
use crate::model::Warning;
use foldhash::HashSet;

/// Items of items may not nest deeper.
const MAX_DEPTH: u8 = 16;
/// Messages of lost items that are kept of one representation.
const MAX_LOST: usize = 10_000;

/// A face as a shell, or a surface as a set, uses it.
#[derive(Clone, Debug)]
pub(super) struct FaceUse {
    pub id: u32,
    pub name: String,
    pub color: Option<[f32; 3]>,
    /// Used against its own orientation.
    pub flipped: bool,
}

/// Another representation that an item puts in place.
#[derive(Clone, Debug)]
pub(super) struct Mapped {
    pub item: u32,
    pub map: u32,
    pub target: u32,
    pub name: String,
}

/// What the items of one representation are made of.
#[derive(Default)]
pub(super) struct Contents {
    /// Faces of closed shells of solids.
    pub solid: Vec<FaceUse>,
    /// All other faces, and bare surfaces.
    pub open: Vec<FaceUse>,
    pub mapped: Vec<Mapped>,
    pub lost: Vec<Warning>,
    /// What is passed over.
    pub warnings: Vec<Warning>,
}

/// Walks through items and marks what it has met, so that what no item leads to can be found after.
pub(super) struct Walker<'f, 'a> {
    pub file: &'f File<'a>,
    pub styles: &'f Styles,
    pub met: HashSet<u32>,
    /// Items that may still be walked through: nests with branches grow like powers.
    pub budget: usize,
}

/// What an item passes on to its faces.
#[derive(Clone, Copy)]
struct Inherited {
    color: Option<[f32; 3]>,
    flipped: bool,
    solid: bool,
    depth: u8,
}

impl Walker<'_, '_> {
    /// The faces of an item; `color` where nothing nearer to a face has one.
    pub fn item(&mut self, id: u32, color: Option<[f32; 3]>, contents: &mut Contents) {
        let from = Inherited { color, flipped: false, solid: false, depth: 0 };
        self.follow(id, from, contents);
    }

    fn follow(&mut self, id: u32, from: Inherited, contents: &mut Contents) {
        if let Err(error) = self.try_follow(id, from, contents)
            && contents.lost.len() < MAX_LOST
        {
            let message = format!("#{id} is lost: {error}");
            contents.lost.push(Warning { entity: Some(id), message });
        }
    }

    fn try_follow(&mut self, id: u32, from: Inherited, contents: &mut Contents) -> Result<(), StepError> {
        if from.depth > MAX_DEPTH || self.budget == 0 {
            return Err(StepError::Depth(id));
        }
        self.budget -= 1;
        self.met.insert(id);
        let entity = self.file.get(id)?;
        let color = self.styles.item(id).or(from.color);
        let inside = Inherited { color, depth: from.depth + 1, ..from };
        let solid = Inherited { solid: true, ..inside };
        match entity.kind {
            Kind::ManifoldSolidBrep | Kind::FacetedBrep => {
                self.follow(entity.args()?.skip(1).reference()?, solid, contents);
            }
            Kind::BrepWithVoids => {
                let mut args = entity.args()?.skip(1);
                self.follow(args.reference()?, solid, contents);
                self.all(args.references()?, solid, contents);
            }
            Kind::ShellBasedSurfaceModel | Kind::FaceBasedSurfaceModel => {
                self.all(entity.args()?.skip(1).references()?, inside, contents);
            }
            Kind::ClosedShell | Kind::OpenShell | Kind::ConnectedFaceSet => {
                self.all(entity.args()?.skip(1).references()?, inside, contents);
            }
            Kind::OrientedClosedShell | Kind::OrientedOpenShell | Kind::OrientedFace => {
                let mut args = entity.args()?.skip(2);
                let element = args.reference()?;
                let flipped = from.flipped ^ !args.flag()?;
                self.follow(element, Inherited { flipped, ..inside }, contents);
            }
            Kind::GeometricSet | Kind::GeometricCurveSet => {
                self.all(entity.args()?.skip(1).references()?, inside, contents);
            }
            Kind::MappedItem => {
                let mut args = entity.args()?;
                let name = args.text();
                let (map, target) = (args.reference()?, args.reference()?);
                contents.mapped.push(Mapped { item: id, map, target, name });
            }
            Kind::Complex => self.complex(&entity, inside, contents)?,
            Kind::Plane | Kind::CylindricalSurface | Kind::ConicalSurface => {
                let message = format!("#{id}: {} that no face bounds is not shown", entity.keyword());
                contents.warnings.push(Warning { entity: Some(id), message });
            }
            _ if is_face(entity.kind) => self.face(&entity, inside, contents)?,
            _ if holds_surfaces(&entity) => return Err(entity.is_not("a shape that is read here")),
            // Points, curves, placements, texts.
            _ => {}
        }
        Ok(())
    }

    fn all(&mut self, ids: Vec<u32>, from: Inherited, contents: &mut Contents) {
        for id in ids {
            self.follow(id, from, contents);
        }
    }

    fn complex(&mut self, entity: &Entity, from: Inherited, contents: &mut Contents) -> Result<(), StepError> {
        let solid = Inherited { solid: true, ..from };
        if let Some(mut outer) = entity.part(Kind::ManifoldSolidBrep) {
            self.follow(outer.reference()?, solid, contents);
            if let Some(mut voids) = entity.part(Kind::BrepWithVoids) {
                self.all(voids.references()?, solid, contents);
            }
        } else if entity.part(Kind::BSplineSurface).is_some() {
            self.face(entity, from, contents)?;
        } else if let Some(mut faces) = entity.part(Kind::ConnectedFaceSet) {
            self.all(faces.references()?, from, contents);
        }
        Ok(())
    }

    fn face(&self, entity: &Entity, from: Inherited, contents: &mut Contents) -> Result<(), StepError> {
        let name = if entity.kind == Kind::Complex {
            entity.part(Kind::RepresentationItem).map(|mut args| args.text())
        } else {
            entity.args().ok().map(|mut args| args.text())
        };
        let (name, color, flipped) = (name.unwrap_or_default(), from.color, from.flipped);
        let color = color.or_else(|| self.surface_color(entity));
        let faces = if from.solid { &mut contents.solid } else { &mut contents.open };
        faces.push(FaceUse { id: entity.id, name, color, flipped });
        Ok(())
    }

    /// Some files style the surface under a face.
    fn surface_color(&self, face: &Entity) -> Option<[f32; 3]> {
        matches!(face.kind, Kind::AdvancedFace | Kind::FaceSurface).then_some(())?;
        self.styles.item(face.args().ok()?.skip(2).optional_reference()?)
    }
}

/// What becomes a face.
fn is_face(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::AdvancedFace
            | Kind::FaceSurface
            | Kind::Face
            | Kind::Subface
            | Kind::BSplineSurface
            | Kind::BSplineSurfaceWithKnots
            | Kind::BezierSurface
            | Kind::UniformSurface
            | Kind::QuasiUniformSurface
            | Kind::RationalBSplineSurface
            | Kind::RectangularTrimmedSurface
            | Kind::CurveBoundedSurface
            | Kind::SphericalSurface
            | Kind::ToroidalSurface
            | Kind::DegenerateToroidalSurface
            | Kind::SurfaceOfLinearExtrusion
            | Kind::SurfaceOfRevolution
            | Kind::OffsetSurface
    )
}

/// Names of shapes that are not read, but would be seen.
fn holds_surfaces(entity: &Entity) -> bool {
    const WORDS: [&str; 11] = [
        "SOLID",
        "TESSELLATED",
        "BREP",
        "CSG",
        "BOOLEAN",
        "SURFACE",
        "SHELL",
        "BLOCK",
        "WEDGE",
        "_CYLINDER",
        "TRIANGULATED",
    ];
    entity.kind == Kind::Other && {
        let keyword = entity.keyword();
        WORDS.iter().any(|word| keyword.contains(word)) && !keyword.contains("CURVE")
    }
}
