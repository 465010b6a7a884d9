//! What a file means: surfaces, faces, parts and where they stand. No pixels.

mod figures;
mod library;
mod measure;
mod select;

pub use figures::{FaceFigures, Figures};
pub use library::{Layout, repeated};
pub use measure::Areas;
pub use select::PartError;

use crate::geometry::{BezierCurve, BezierPatch, PatchPiece};
use glam::{DAffine3, DVec3};
use serde::Serialize;
use std::ops::Range;
use std::sync::Arc;

/// Everything that was read from one file (or built in).
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub name: String,
    pub parts: Vec<Part>,
    pub instances: Vec<Instance>,
    /// Length unit as the file names it ("mm"), where it does.
    pub unit: Option<String>,
    /// What was mended or approximated, one line each; never silent.
    pub warnings: Vec<Warning>,
    /// Faces that could not be converted, with the reason.
    pub lost: Vec<Warning>,
    /// What the file has and no picture is to show.
    pub unshown: Unshown,
    /// Other numbers of parts in the file, each with a part's own: those of products and of their versions.
    pub aliases: Vec<[u32; 2]>,
}

/// What is left out because it is no face, or because the file hides it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unshown {
    pub hidden_faces: usize,
    /// Curves that bound no face.
    pub lone_curves: usize,
}

/// Faces that move together; drawn once per instance, never copied.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// The file's own number of the product or solid, 0 where it has none.
    pub id: u32,
    pub name: String,
    pub faces: Vec<Face>,
    pub solidity: Solidity,
    /// Solids, shells, sets and representations in it.
    pub groups: Vec<Group>,
}

/// Some faces of a part that the file has a number for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Group {
    pub id: u32,
    pub name: String,
    /// Its faces bound a solid with outward normals.
    pub is_solid: bool,
    pub faces: Range<usize>,
}

/// Whether a part's faces bound a solid with outward normals (`S_u x S_v`), so that back faces can't be seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solidity {
    /// The format doesn't say; prepare looks for matching borders.
    #[default]
    Unknown,
    Solid,
    Open,
}

/// A surface, trimmed by loops in its parameter plane.
#[derive(Clone, Debug, Default)]
pub struct Face {
    /// The file's own entity number where it has one, else the running number from 0.
    pub id: u32,
    /// Shared with the scene, like the loops: a library of millions of faces is there once.
    pub name: Arc<str>,
    /// Linear RGB; `None`: the renderer's default.
    pub color: Option<[f32; 3]>,
    pub kind: SurfaceKind,
    pub surface: Surface,
    /// The face is what lies inside by the odd-even rule; without loops it is the whole surface.
    pub loops: Arc<[Loop]>,
    /// The face's outward normal is `-(S_u x S_v)`.
    pub reversed: bool,
    pub approximation: Approximation,
}

/// Trim curves of a face that follow their edges' images without being these images.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Approximation {
    pub curves: u32,
    /// Largest distance in space that was found, in the part's units.
    pub error: f64,
}

/// What the file calls the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum SurfaceKind {
    Plane,
    Cylinder,
    Cone,
    Sphere,
    Torus,
    Extrusion,
    Revolution,
    Offset,
    BSpline,
    #[default]
    Bezier,
}

/// A closed sequence of curves in the parameter plane, the end of each at the start of the next.
///
/// The plane is the one of [`SurfacePatch::domain`]: inside a patch it is affine in the patch's Bézier parameters. (On an
/// arc that is not proportional to the angle; the two agree where arcs meet.) Curves do not cross from one patch to
/// another where that map has a kink.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loop {
    pub curves: Vec<TrimCurve>,
}

/// One rational Bézier piece of a trim loop; z is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct TrimCurve {
    pub curve: BezierCurve,
    /// Largest distance in space between the curve's image on the surface and the edge it stands for, in the part's
    /// units: measured, never the file's tolerance.
    pub gap: f64,
    /// The file's own number of the edge, the same in all faces that meet there; `None` for what only closes a loop along
    /// a seam or at a pole.
    pub edge: Option<u32>,
}

/// A surface as rational Bézier patches, each with its rectangle in the surface's parameter plane.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    pub patches: Vec<SurfacePatch>,
}

#[derive(Clone, Debug)]
pub struct SurfacePatch {
    pub patch: BezierPatch,
    /// `[[u0, u1], [v0, v1]]`
    pub domain: [[f64; 2]; 2],
}

/// A part placed in the world.
#[derive(Clone, Debug, Default)]
pub struct Instance {
    pub part: usize,
    pub transform: DAffine3,
    pub name: String,
    /// Overrides the faces' colours where set.
    pub color: Option<[f32; 3]>,
    /// Colours of single faces in this place, which override both: by the face's index in the part, ascending.
    pub face_colors: Vec<(usize, [f32; 3])>,
    /// The file's numbers on the way from the top: of parts, and of their uses in each other.
    pub path: Vec<u32>,
}

/// Something that was left out or mended while reading.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Entity number or line, as the message says.
    pub entity: Option<u32>,
    pub message: String,
}

impl Face {
    /// A whole surface, untrimmed and uncoloured.
    pub fn new(id: u32, name: impl Into<Arc<str>>, surface: Surface) -> Self {
        Self { id, name: name.into(), surface, ..Self::default() }
    }
}

impl Surface {
    /// One patch over the unit square.
    pub fn single(patch: BezierPatch) -> Self {
        Self { patches: vec![SurfacePatch { patch, domain: [[0.0, 1.0], [0.0, 1.0]] }] }
    }
}

impl From<Vec<PatchPiece>> for Surface {
    fn from(pieces: Vec<PatchPiece>) -> Self {
        let patches = pieces.into_iter().map(|PatchPiece { patch, domain }| SurfacePatch { patch, domain });
        Self { patches: patches.collect() }
    }
}

impl Model {
    /// A model of one part, placed once as it is.
    pub fn from_part(name: impl Into<String>, part: Part) -> Self {
        let name = name.into();
        let instance = Instance { name: part.name.clone(), ..Instance::default() };
        Self { name, parts: vec![part], instances: vec![instance], ..Self::default() }
    }

    /// Axis-aligned box of all control points in the world; `None` for a model without faces.
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let mut bounds: Option<[DVec3; 2]> = None;
        for instance in &self.instances {
            let faces = &self.parts[instance.part].faces;
            for patch in faces.iter().flat_map(|f| &f.surface.patches) {
                for point in patch.patch.net().hull() {
                    let p = instance.transform.transform_point3(point);
                    let [lo, hi] = bounds.unwrap_or([p, p]);
                    bounds = Some([lo.min(p), hi.max(p)]);
                }
            }
        }
        bounds
    }
}
