//! From the items of a representation to the faces that they are made of.

use super::error::StepError;
use super::file::{Entity, File};
use super::kinds::Kind;
use super::styles::Styles;
use crate::model::{Unshown, Warning};
use foldhash::HashSet;
use std::ops::Range;

/// Items of items may not nest deeper.
const MAX_DEPTH: u8 = 16;

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
    pub hidden: bool,
}

/// A solid, shell or set: which faces it has, as ranges of the contents' two lists.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub id: u32,
    pub name: String,
    /// Its faces bound a solid, outward.
    pub is_solid: bool,
    pub solid: Range<usize>,
    pub open: Range<usize>,
}

/// What the items of one representation are made of.
#[derive(Default)]
pub(super) struct Contents {
    /// Faces of closed shells of solids.
    pub solid: Vec<FaceUse>,
    /// All other faces, and bare surfaces.
    pub open: Vec<FaceUse>,
    pub mapped: Vec<Mapped>,
    pub groups: Vec<Group>,
    pub lost: Vec<Warning>,
    /// What is passed over.
    pub warnings: Vec<Warning>,
    pub unshown: Unshown,
}

/// Walks through items and marks what it has met, so that what no item leads to can be found after.
pub(super) struct Walker<'f, 'a> {
    pub file: &'f File<'a>,
    pub styles: &'f Styles,
    pub met: HashSet<u32>,
    /// Items that have been told to be lost: once each, however often they are used.
    pub told: HashSet<u32>,
    /// Items that may still be walked through: nests with branches grow like powers.
    pub budget: usize,
}

/// What an item passes on to its faces.
#[derive(Clone, Copy)]
struct Inherited {
    color: Option<[f32; 3]>,
    flipped: bool,
    solid: bool,
    hidden: bool,
    depth: u8,
}

impl Walker<'_, '_> {
    /// The faces of an item; `color` where nothing nearer to a face has one.
    pub fn item(&mut self, id: u32, color: Option<[f32; 3]>, contents: &mut Contents) {
        self.item_of(id, color, false, contents);
    }

    /// As [`Walker::item`], of a representation that may be hidden.
    pub fn item_of(&mut self, id: u32, color: Option<[f32; 3]>, hidden: bool, contents: &mut Contents) {
        let from = Inherited { color, flipped: false, solid: false, hidden, depth: 0 };
        self.follow(id, from, contents);
    }

    fn follow(&mut self, id: u32, from: Inherited, contents: &mut Contents) {
        if let Err(error) = self.try_follow(id, from, contents)
            && self.told.insert(id)
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
        let hidden = from.hidden || self.styles.is_hidden(id);
        let inside = Inherited { color, hidden, depth: from.depth + 1, ..from };
        let before = [contents.solid.len(), contents.open.len()];
        self.enter(&entity, from.flipped, inside, contents)?;
        if is_group(&entity) {
            contents.group(&entity, before);
        }
        Ok(())
    }

    /// What an entity is made of.
    fn enter(
        &mut self,
        entity: &Entity,
        flipped: bool,
        inside: Inherited,
        contents: &mut Contents,
    ) -> Result<(), StepError> {
        let id = entity.id;
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
                let flipped = flipped ^ !args.flag()?;
                self.follow(element, Inherited { flipped, ..inside }, contents);
            }
            Kind::GeometricSet | Kind::GeometricCurveSet => {
                self.all(entity.args()?.skip(1).references()?, inside, contents);
            }
            Kind::MappedItem => {
                let mut args = entity.args()?;
                let name = args.text();
                let (map, target) = (args.reference()?, args.reference()?);
                contents.mapped.push(Mapped { item: id, map, target, name, hidden: inside.hidden });
            }
            Kind::Complex => self.complex(entity, inside, contents)?,
            Kind::Plane | Kind::CylindricalSurface | Kind::ConicalSurface => {
                let message = format!("#{id}: {} that no face bounds is not shown", entity.keyword());
                contents.warnings.push(Warning { entity: Some(id), message });
            }
            _ if is_face(entity.kind) => self.face(entity, inside, contents)?,
            _ if is_curve(entity.kind) => contents.unshown.lone_curves += usize::from(!inside.hidden),
            _ if holds_surfaces(entity) => return Err(entity.is_not("a shape that is read here")),
            // Points, placements, texts.
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
        } else if [Kind::BSplineCurve, Kind::SurfaceCurve, Kind::CompositeCurve]
            .into_iter()
            .any(|k| entity.part(k).is_some())
        {
            contents.unshown.lone_curves += usize::from(!from.hidden);
        }
        Ok(())
    }

    fn face(&mut self, entity: &Entity, from: Inherited, contents: &mut Contents) -> Result<(), StepError> {
        if entity.kind == Kind::Subface {
            // The face that it is a part of is not shown for itself.
            self.met.extend(entity.args()?.skip(2).optional_reference());
        }
        if from.hidden {
            contents.unshown.hidden_faces += 1;
            return Ok(());
        }
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

impl Contents {
    /// Notes the faces since there were so many.
    fn group(&mut self, entity: &Entity, [solid, open]: [usize; 2]) {
        let (solid, open) = (solid..self.solid.len(), open..self.open.len());
        if solid.is_empty() && open.is_empty() {
            return;
        }
        let name = match entity.kind {
            Kind::Complex => entity.part(Kind::RepresentationItem).map(|mut args| args.text()),
            _ => entity.args().ok().map(|mut args| args.text()),
        };
        let is_solid = is_solid(entity);
        self.groups.push(Group { id: entity.id, name: name.unwrap_or_default(), is_solid, solid, open });
    }
}

fn is_solid(entity: &Entity) -> bool {
    match entity.kind {
        Kind::ManifoldSolidBrep | Kind::FacetedBrep | Kind::BrepWithVoids => true,
        Kind::Complex => entity.part(Kind::ManifoldSolidBrep).is_some(),
        _ => false,
    }
}

/// What holds faces and may be looked at alone.
fn is_group(entity: &Entity) -> bool {
    match entity.kind {
        Kind::ShellBasedSurfaceModel
        | Kind::FaceBasedSurfaceModel
        | Kind::ClosedShell
        | Kind::OpenShell
        | Kind::ConnectedFaceSet
        | Kind::OrientedClosedShell
        | Kind::OrientedOpenShell
        | Kind::GeometricSet
        | Kind::GeometricCurveSet => true,
        Kind::Complex => is_solid(entity) || entity.part(Kind::ConnectedFaceSet).is_some(),
        _ => is_solid(entity),
    }
}

/// Curves for themselves: wires, sketches, annotations.
fn is_curve(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Line
            | Kind::Circle
            | Kind::Ellipse
            | Kind::Parabola
            | Kind::Hyperbola
            | Kind::Polyline
            | Kind::TrimmedCurve
            | Kind::CompositeCurve
            | Kind::CompositeCurveOnSurface
            | Kind::BoundaryCurve
            | Kind::OuterBoundaryCurve
            | Kind::BSplineCurve
            | Kind::BSplineCurveWithKnots
            | Kind::BezierCurve
            | Kind::UniformCurve
            | Kind::QuasiUniformCurve
            | Kind::RationalBSplineCurve
            | Kind::SurfaceCurve
            | Kind::SeamCurve
            | Kind::IntersectionCurve
            | Kind::BoundedSurfaceCurve
            | Kind::Pcurve
            | Kind::OffsetCurve3d
            | Kind::CurveReplica
    )
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
            | Kind::SurfaceReplica
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
