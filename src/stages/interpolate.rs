//! The parameters of a pixel on its triangle or stroke, before refinement.

use super::evaluate::{Meshlet, Meshlets, SUBPIXELS, Vertex};
use super::rasterize::Triangle;
use super::stroke::{nearest, nearest_in_triangle};
use super::topology::{Primitive, index_of, meshlet_of, primitive};

/// What a visibility word shows, ready for many pixels.
pub(super) enum Shown {
    /// With the weights of the corners for their depths, and their leaf parameters.
    Triangle(Triangle, [[f32; 2]; 3]),
    Edge([Vertex; 2], [[f32; 2]; 2]),
}

impl Shown {
    /// `quads`: of the whole leaf.
    pub fn new(meshlets: &Meshlets, quads: [u32; 2], word: u64) -> Self {
        let meshlet = &meshlets.meshlets[meshlet_of(word) as usize];
        let vertex = |[i, j]: [usize; 2]| meshlets.vertices[meshlet.vertex(i, j)];
        match primitive(meshlet, index_of(word)) {
            Primitive::Edge([a, b, _]) => {
                Self::Edge([a, b].map(vertex), [a, b].map(|corner| parameters(meshlet, quads, corner)))
            }
            Primitive::Triangle(mut corners) => {
                let mut vertices = corners.map(vertex);
                let mut t = Triangle::new(&vertices);
                // `Triangle` turned the corners so that the area is positive: follow it.
                if i64::from(vertices[1].x) != t.x[1] || i64::from(vertices[1].y) != t.y[1] {
                    corners.swap(1, 2);
                    vertices.swap(1, 2);
                }
                t.depth = vertices.map(|v| v.weight);
                Self::Triangle(t, corners.map(|corner| parameters(meshlet, quads, corner)))
            }
        }
    }

    /// Leaf parameters (s, t) at pixel (x, y): perspective-correct with the weights that the bound's interpolation asks
    /// for; from the nearest point where the centre is not inside.
    pub fn at(&self, x: u32, y: u32) -> [f32; 2] {
        let (px, py) = (center(x), center(y));
        match self {
            Self::Triangle(t, corners) => in_triangle(t, corners, px, py),
            Self::Edge(ends, parameters) => on_edge(ends, parameters, px, py),
        }
    }
}

/// [`Shown::at`] for one pixel.
pub(super) fn interpolate(meshlets: &Meshlets, quads: [u32; 2], word: u64, x: u32, y: u32) -> [f32; 2] {
    Shown::new(meshlets, quads, word).at(x, y)
}

/// Leaf parameters of the three corners of a word's triangle.
pub(super) fn corner_parameters(meshlets: &Meshlets, quads: [u32; 2], word: u64) -> [[f32; 2]; 3] {
    let meshlet = &meshlets.meshlets[meshlet_of(word) as usize];
    let (Primitive::Triangle(corners) | Primitive::Edge(corners)) = primitive(meshlet, index_of(word));
    corners.map(|corner| parameters(meshlet, quads, corner))
}

fn center(pixel: u32) -> i64 {
    i64::from(pixel) * i64::from(SUBPIXELS) + i64::from(SUBPIXELS / 2)
}

/// Leaf parameters of a vertex of the meshlet's grid.
fn parameters(meshlet: &Meshlet, quads: [u32; 2], corner: [usize; 2]) -> [f32; 2] {
    std::array::from_fn(|k| (u32::from(meshlet.first[k]) + corner[k] as u32) as f32 / quads[k] as f32)
}

fn in_triangle(t: &Triangle, corners: &[[f32; 2]; 3], px: i64, py: i64) -> [f32; 2] {
    let e: [i64; 3] = std::array::from_fn(|k| t.edge(k, px, py));
    let mut weights = [e[1] as f32, e[2] as f32, e[0] as f32];
    if t.area == 0 || e.iter().any(|&e| e < 0) {
        weights = nearest_in_triangle(t, px, py);
    }
    let scaled: [f32; 3] = std::array::from_fn(|k| weights[k] * t.depth[k]);
    let sum = scaled[0] + scaled[1] + scaled[2];
    std::array::from_fn(|k| (scaled[0] * corners[0][k] + scaled[1] * corners[1][k] + scaled[2] * corners[2][k]) / sum)
}

fn on_edge([a, b]: &[Vertex; 2], [p, q]: &[[f32; 2]; 2], px: i64, py: i64) -> [f32; 2] {
    let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
    let s = nearest(dx * (px - i64::from(a.x)) + dy * (py - i64::from(a.y)), dx * dx + dy * dy);
    // Linear on the screen with the weights of the ends, so that the parameter is linear in space.
    let (wa, wb) = ((1.0 - s) * a.weight, s * b.weight);
    let t = wb / (wa + wb);
    std::array::from_fn(|k| p[k] + (q[k] - p[k]) * t)
}
