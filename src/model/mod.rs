//! What a file means: surfaces, faces, parts and where they stand. No pixels.

mod figures;

pub use figures::Figures;

use crate::geometry::{BezierPatch, PatchPiece};
use glam::{DAffine3, DVec3};

/// Everything that was read from one file (or built in).
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub name: String,
    pub parts: Vec<Part>,
    pub instances: Vec<Instance>,
    /// Length unit as the file names it ("mm"), where it does.
    pub unit: Option<String>,
    /// What could not be taken over, one line each; never silent.
    pub warnings: Vec<Warning>,
}

/// Faces that move together; drawn once per instance, never copied.
#[derive(Clone, Debug, Default)]
pub struct Part {
    pub name: String,
    pub faces: Vec<Face>,
    pub solidity: Solidity,
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

/// A surface, later with trim loops in its parameter plane.
#[derive(Clone, Debug)]
pub struct Face {
    /// The file's own entity number where it has one, else the running number from 0.
    pub id: u32,
    pub name: String,
    /// Linear RGB; `None`: the renderer's default.
    pub color: Option<[f32; 3]>,
    pub surface: Surface,
}

/// A surface as rational Bézier patches, each with its rectangle in the surface's own parameters.
#[derive(Clone, Debug)]
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
#[derive(Clone, Debug)]
pub struct Instance {
    pub part: usize,
    pub transform: DAffine3,
    pub name: String,
    /// Overrides the faces' colours where set.
    pub color: Option<[f32; 3]>,
}

/// Something that was left out or mended while reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Entity number or line, as the message says.
    pub entity: Option<u32>,
    pub message: String,
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
        let instance = Instance { part: 0, transform: DAffine3::IDENTITY, name: part.name.clone(), color: None };
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
