//! A pile of closed rings of polynomial bicubic patches: many small patches, most of them behind others, as in assemblies.

use crate::geometry::{BezierPatch, PatchPiece};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Patches along a ring and around its tube. 65 copies at 3840x2160 and zoom 3 are 3.7 million patches, 48 % of them culled and
/// the others with 2.4 quads each: bench/README.md, "rings".
const PATCHES: [usize; 2] = [16, 14];
const RADII: [f64; 2] = [1.0, 0.4];
/// Rings along x, y and z, and how far apart they are: they don't touch.
const RINGS: [usize; 3] = [4, 4, 16];
const PITCH: DVec3 = DVec3::new(3.0, 3.0, 0.9);

/// All rings of the pile.
pub fn pile() -> Vec<Vec<PatchPiece>> {
    let [nx, ny, nz] = RINGS;
    let places =
        (0..nx * ny * nz).map(|k| PITCH * DVec3::new((k % nx) as f64, (k / nx % ny) as f64, (k / nx / ny) as f64));
    places.map(ring).collect()
}

/// A torus but for what cubics are off a circle. The product of two cubic curves is a bicubic patch; neighbours share their
/// borders' points.
pub fn ring(centre: DVec3) -> Vec<PatchPiece> {
    let [major, minor] = RADII;
    let [along, around] = PATCHES.map(circle);
    let place = |p: DVec2, q: DVec2| centre + (p * (major + minor * q.x)).extend(minor * q.y);
    let patch = |a: &[DVec2; 4], b: &[DVec2; 4]| {
        let points = a.iter().flat_map(|&p| b.iter().map(move |&q| place(p, q).extend(1.0)));
        PatchPiece { patch: BezierPatch::from_points([3, 3], points.collect()), domain: [[0.0, 1.0]; 2] }
    };
    along.iter().flat_map(|a| around.iter().map(move |b| patch(a, b))).collect()
}

/// The unit circle by cubic arcs that agree with it in ends, tangents and middles.
fn circle(arcs: usize) -> Vec<[DVec2; 4]> {
    let angle = TAU / arcs as f64;
    let ends: Vec<DVec2> = (0..arcs).map(|k| DVec2::from_angle(angle * k as f64)).collect();
    let tangent = 4.0 / 3.0 * (0.25 * angle).tan();
    let arc = |k: usize| {
        let (a, b) = (ends[k], ends[(k + 1) % arcs]);
        [a, a + tangent * a.perp(), b - tangent * b.perp(), b]
    };
    (0..arcs).map(arc).collect()
}
