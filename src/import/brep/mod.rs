//! Faces of boundary representations: from edges in space to loops of rational Bézier curves in the parameter plane.
//!
//! A reader of STEP or the like hands over a [`FaceSource`]; [`build_face`] makes the [`Face`] of it.

use crate::geometry::{CurveSpan, GeometryError, SurfaceForm};
use crate::model::{Face, SurfaceKind};
use glam::DVec3;
use thiserror::Error;

/// One edge as a loop runs along it.
#[derive(Clone, Debug)]
pub(crate) struct EdgeUse {
    /// Entity number of the edge.
    pub edge: u32,
    /// In model units, in the loop's direction from start to end vertex, joined end to end.
    pub spans: Vec<CurveSpan>,
    /// The file's candidates on this face's surface: z = 0, in the surface's ISO 10303-42 parameters, same direction;
    /// none, one, or two on a seam.
    pub pcurves: Vec<Vec<CurveSpan>>,
    /// The vertices, in the loop's direction.
    pub ends: [DVec3; 2],
}

/// A bound of a face.
#[derive(Clone, Debug)]
pub(crate) enum Bound {
    Edges(Vec<EdgeUse>),
    Vertex(DVec3),
}

/// A face before its loops are in the parameter plane.
#[derive(Clone, Debug)]
pub(crate) struct FaceSource {
    pub id: u32,
    pub name: String,
    pub color: Option<[f32; 3]>,
    pub kind: SurfaceKind,
    pub surface: SurfaceForm,
    /// Of a rectangular trimmed surface: bounds in the surface's parameters.
    pub domain: Option<[[f64; 2]; 2]>,
    /// In the direction that has the material to its left seen from `S_u x S_v`, if the file is right.
    pub bounds: Vec<Bound>,
    /// The face's outward normal is `-(S_u x S_v)`.
    pub reversed: bool,
    /// The file's uncertainty, in model units.
    pub tolerance: f64,
}

/// A face and what was mended in it.
#[derive(Clone, Debug)]
pub(crate) struct Built {
    pub face: Face,
    pub warnings: Vec<String>,
}

/// Why a face is lost.
#[derive(Clone, Debug, Error)]
pub(crate) enum BrepError {
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("the face has no bounds and its surface is unbounded")]
    Unbounded,
}

/// The face with its loops in the surface's parameter plane and the patches that cover them.
pub(crate) fn build_face(source: &FaceSource) -> Result<Built, BrepError> {
    let _ = source;
    Err(BrepError::Unbounded)
}
