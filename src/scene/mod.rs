//! Prepare: rational Bézier patches about local origins with what the frame needs to know of them, and cameras.

mod camera;
mod closure;
mod enclosure;
mod prepare;
mod trim_build;
mod trim_faces;
mod trim_lines;
mod trim_segment;
mod trim_tree;

pub use camera::{Camera, CameraError, MAX_SIDE, Projection, View, ViewSpec};
pub use closure::visible_sides;
pub use enclosure::{enclose, normal_cone, radius};
pub use prepare::{PrepareError, prepare};
pub use trim_lines::Window;
pub use trim_segment::ParameterBox;
pub(crate) use trim_segment::Segment;
pub(crate) use trim_tree::{Clip, Exit, Node, Tree};
pub use trim_tree::{Region, TrimTree, Trims};

use crate::geometry::Net;
use crate::model::Loop;
use glam::{DAffine3, DVec3, DVec4};
use std::ops::Range;
use std::sync::Arc;

/// A prepared model. Patches belong to parts; instances draw ranges of them.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Control nets of all patches, homogeneous, about each patch's own origin.
    pub points: Vec<DVec4>,
    pub patches: Vec<Patch>,
    pub faces: Vec<SceneFace>,
    pub instances: Vec<SceneInstance>,
    pub bounds: Bounds,
    /// The trim trees of all faces that loops cut.
    pub trims: Trims,
}

/// One rational Bézier patch about a local origin.
#[derive(Clone, Debug)]
pub struct Patch {
    pub degree: [usize; 2],
    /// Its net in `Scene::points`.
    pub points: Range<usize>,
    /// Local (0, 0, 0) in the part's coordinates.
    pub origin: DVec3,
    /// Index into `Scene::faces`.
    pub face: u32,
    /// Its rectangle in the source surface's own parameters.
    pub domain: [[f64; 2]; 2],
    pub rational: bool,
    pub enclosure: Enclosure,
    pub cone: NormalCone,
    /// All of it lies so near to its origin.
    pub radius: f64,
    pub trim: PatchTrim,
}

/// What a face's loops leave of one of its patches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchTrim {
    /// The tree in `Scene::trims` that tells inside from outside; `None`: all of the patch is inside.
    pub tree: Option<u32>,
    /// The face ends at one of the patch's borders: trim curves run along it, or the whole surface ends there, in a model
    /// with trims.
    pub rim: bool,
    /// Largest gap of the curves along its borders, in the part's units.
    pub gap: f64,
}

/// Signed boxes and radii that hold `S_uu`, `S_uv`, `S_vv` of the rational surface over the patch (21 numbers);
/// research "tessellation-bounds", M7bn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Enclosure {
    /// `[uu, uv, vv]`, model axes.
    pub low: [DVec3; 3],
    pub high: [DVec3; 3],
    /// Largest length of each.
    pub radius: [f64; 3],
}

/// All normals `S_u x S_v` of the patch lie within `angle` of `axis`; `cos_angle < 0` (or -1) says nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalCone {
    pub axis: DVec3,
    pub cos_angle: f64,
}

#[derive(Clone, Debug)]
pub struct SceneFace {
    /// The file's own entity number where it has one.
    pub id: u32,
    pub name: Arc<str>,
    /// Linear RGB.
    pub color: [f32; 3],
    /// Which side of the surface can be seen.
    pub sides: Sides,
    /// Trim loops in the plane of [`Patch::domain`]; none: the face is all of its patches.
    pub loops: Arc<[Loop]>,
}

/// The sides of a face that can be seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    #[default]
    Both,
    /// The face bounds a solid and `S_u x S_v` points outwards.
    Outside,
    /// The face bounds a solid and `S_u x S_v` points inwards.
    Inside,
}

impl Patch {
    /// The point of the surface's own parameters for one of the unit square.
    pub fn to_plane(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.domain[k][0] + (self.domain[k][1] - self.domain[k][0]) * uv[k])
    }
}

impl Sides {
    /// The same for a face whose outward normal is `-(S_u x S_v)`.
    pub fn turned(self) -> Self {
        match self {
            Self::Both => Self::Both,
            Self::Outside => Self::Inside,
            Self::Inside => Self::Outside,
        }
    }
}

#[derive(Clone, Debug)]
pub struct SceneInstance {
    pub name: String,
    /// The patches it draws, in `Scene::patches`.
    pub patches: Range<usize>,
    /// Part coordinates to world.
    pub transform: DAffine3,
    pub color: Option<[f32; 3]>,
    /// Colours of single faces in this place, by their index in `Scene::faces`, ascending.
    pub face_colors: Vec<(u32, [f32; 3])>,
}

/// Box of all control points in the world, and the sphere about it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    pub low: DVec3,
    pub high: DVec3,
}

impl Bounds {
    pub fn center(&self) -> DVec3 {
        // Halves first: the sum may overflow.
        self.low * 0.5 + self.high * 0.5
    }

    /// Radius of the bounding sphere (half the diagonal).
    pub fn radius(&self) -> f64 {
        (self.high * 0.5 - self.low * 0.5).length()
    }
}

impl Scene {
    /// The control net of a patch, about its origin.
    pub fn net(&self, patch: &Patch) -> Net<'_> {
        Net::new(patch.degree, &self.points[patch.points.clone()])
    }

    /// Memory of the trim trees, in bytes.
    pub fn trim_bytes(&self) -> usize {
        self.trims.bytes()
    }

    /// The trims of a patch that loops cut, and the patch's rectangle in their plane.
    pub fn trim_tree(&self, patch: &Patch) -> Option<TrimTree<'_>> {
        patch.trim.tree.map(|tree| self.trims.tree(tree))
    }

    /// What one drawn patch is coloured: as the instance says of its face, or of the whole, else as the face is.
    pub fn color(&self, instance: u32, patch: u32) -> [f32; 3] {
        let face = self.patches[patch as usize].face;
        let SceneInstance { color, face_colors, .. } = &self.instances[instance as usize];
        let own = face_colors.binary_search_by_key(&face, |&(face, _)| face);
        let own = own.ok().map(|k| face_colors[k].1);
        own.or(*color).unwrap_or(self.faces[face as usize].color)
    }
}
