//! The parameters of a pixel on its triangle or stroke, before refinement.

use super::evaluate::{Meshlet, Meshlets, SUBPIXELS};
use super::rasterize::Triangle;
use super::stroke::{nearest, nearest_in_triangle};
use super::topology::{Primitive, index_of, meshlet_of, primitive};

/// Leaf parameters (s, t) of the word that pixel (x, y) shows: perspective-correct with the weights that the bound's
/// interpolation asks for; from the nearest point where the centre is not inside.
pub(super) fn interpolate(meshlets: &Meshlets, quads: [u32; 2], word: u64, x: u32, y: u32) -> [f32; 2] {
    let meshlet = &meshlets.meshlets[meshlet_of(word) as usize];
    let (px, py) = (center(x), center(y));
    match primitive(meshlet, index_of(word)) {
        Primitive::Triangle(corners) => in_triangle(meshlets, meshlet, quads, corners, px, py),
        Primitive::Edge([a, b, _]) => on_edge(meshlets, meshlet, quads, [a, b], px, py),
    }
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

fn in_triangle(
    meshlets: &Meshlets,
    meshlet: &Meshlet,
    quads: [u32; 2],
    mut corners: [[usize; 2]; 3],
    px: i64,
    py: i64,
) -> [f32; 2] {
    let mut vertices = corners.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
    let mut t = Triangle::new(&vertices);
    // `Triangle` turned the corners so that the area is positive: follow it.
    if i64::from(vertices[1].x) != t.x[1] || i64::from(vertices[1].y) != t.y[1] {
        corners.swap(1, 2);
        vertices.swap(1, 2);
    }
    t.depth = vertices.map(|v| v.weight);
    let e: [i64; 3] = std::array::from_fn(|k| t.edge(k, px, py));
    let mut weights = [e[1] as f32, e[2] as f32, e[0] as f32];
    if t.area == 0 || e.iter().any(|&e| e < 0) {
        weights = nearest_in_triangle(&t, px, py);
    }
    let scaled: [f32; 3] = std::array::from_fn(|k| weights[k] * t.depth[k]);
    let sum = scaled[0] + scaled[1] + scaled[2];
    let corners = corners.map(|c| parameters(meshlet, quads, c));
    std::array::from_fn(|k| (scaled[0] * corners[0][k] + scaled[1] * corners[1][k] + scaled[2] * corners[2][k]) / sum)
}

fn on_edge(
    meshlets: &Meshlets,
    meshlet: &Meshlet,
    quads: [u32; 2],
    ends: [[usize; 2]; 2],
    px: i64,
    py: i64,
) -> [f32; 2] {
    let [a, b] = ends.map(|[i, j]| meshlets.vertices[meshlet.vertex(i, j)]);
    let (dx, dy) = (i64::from(b.x - a.x), i64::from(b.y - a.y));
    let s = nearest(dx * (px - i64::from(a.x)) + dy * (py - i64::from(a.y)), dx * dx + dy * dy);
    // Linear on the screen with the weights of the ends, so that the parameter is linear in space.
    let (wa, wb) = ((1.0 - s) * a.weight, s * b.weight);
    let t = wb / (wa + wb);
    let [p, q] = ends.map(|c| parameters(meshlet, quads, c));
    std::array::from_fn(|k| p[k] + (q[k] - p[k]) * t)
}
