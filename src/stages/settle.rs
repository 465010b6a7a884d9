//! Part of shade: which of the filled pixels were gaps, now that the exact surface is asked (DESIGN section 4,
//! "Refinement").
//!
//! A gap between two grids is no gap of the surface: some patch lies exactly under its pixel's centre. A stroke that
//! sticks out past the outline of a surface has none there.

use super::estimate::Tessellation;
use super::fill::Filled;
use super::frame::Targets;
use super::interpolate::corner_parameters;
use super::newton::{Batch, LANES, Surface};
use super::settle_near::{Candidate, by_band};
use super::shade::Shader;
use super::stroke::may_fold;
use super::topology::{Primitive, depth_of, index_of, meshlet_of, primitive, with_depth};
use super::trim_cut::{self, Cut, keeps};
use rayon::prelude::*;

/// Pixels between a pixel centre and a projected surface point that count as none.
pub(super) const EXACT: f32 = 1.0 / 128.0;
/// Starts nearer to each other than this part of a quad, in both parameters, lead to the same point: nearest points, which
/// neighbouring triangles have in common, and corners.
const POINTS_APART: f32 = 0.25;
const CORNERS_APART: f32 = 0.5;
/// What the contract allows a filled pixel.
const HALF_PIXEL: f32 = 0.5;

/// A surface point under a pixel's centre.
struct Hit {
    /// Stored depth.
    depth: f32,
    /// Its triangle, as the lower half of a visibility word.
    triangle: u64,
    /// Leaf parameters.
    parameters: [f32; 2],
}

impl Hit {
    /// As a visibility word.
    fn word(&self) -> u64 {
        with_depth(self.triangle, self.depth)
    }
}

/// Strokes: a pixel goes to the nearest surface exactly under its centre, where that is nearer than what N shows; else
/// back to N.
pub(super) fn settle(shader: &Shader, targets: &mut Targets, filled: &mut Vec<Filled>) {
    // N's own surface lies within the depth tolerance of its depth: only what is clearly nearer counts.
    let behind = filled.par_iter().map(|f| shader.nearer_by_tolerance(depth_of(f.near), 1.0)).collect();
    let mut hits = nearest_hits(shader, filled, behind, true).into_iter();
    filled.retain_mut(|f| {
        let hit = hits.next().flatten();
        targets.near[f.pixel as usize] = hit.as_ref().map_or(f.near, Hit::word);
        f.start = hit.map(|hit| hit.parameters);
        f.start.is_some()
    });
}

/// A pixel whose exact point is not where the depth test took it to be: `filled.near` has its exact depth.
pub(super) struct Doubt {
    pub filled: Filled,
    pub kind: DoubtKind,
}

/// How well a point is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DoubtKind {
    /// Under the pixel's centre, but elsewhere in depth.
    Deep,
    /// Not under the centre, or of the inside of a solid.
    Beside,
    /// Not under the centre, since the patch ends before.
    Ended,
}

/// Pixels in doubt, in image order: another surface that is nearer under the centre takes them, and where the point shown is
/// none under the centre, one that is; else the exact depth stands. Those taken join `filled`. A surface is shown
/// already, so that no gap is to be closed here.
pub(super) fn resettle(shader: &Shader, targets: &mut Targets, doubts: &[Doubt], filled: &mut Vec<Filled>) {
    let behind = doubts.par_iter().map(|doubt| match doubt.kind {
        DoubtKind::Deep => shader.nearer_by_tolerance(depth_of(doubt.filled.near), 1.0),
        DoubtKind::Beside => shader.nearer_by_tolerance(depth_of(doubt.filled.near), -1.0),
        DoubtKind::Ended => 0.0,
    });
    let pixels: Vec<Filled> = doubts.iter().map(|doubt| doubt.filled).collect();
    let hits = nearest_hits(shader, &pixels, behind.collect(), false);
    for (f, hit) in pixels.into_iter().zip(hits) {
        targets.near[f.pixel as usize] = hit.as_ref().map_or(f.near, Hit::word);
        filled.extend(hit.map(|hit| Filled { start: Some(hit.parameters), ..f }));
    }
    filled.sort_unstable_by_key(|f| f.pixel);
}

/// Other ways to fill: what refinement leaves beyond half a pixel goes back to N.
pub(super) fn refuse(shader: &Shader, targets: &mut Targets, filled: &mut Vec<Filled>) {
    let stays = |f: &Filled| shader.surfel(targets.near[f.pixel as usize], f).residual <= HALF_PIXEL;
    let stays: Vec<bool> = filled.par_iter().map(stays).collect();
    let mut stays = stays.into_iter();
    filled.retain(|f| {
        let stays = stays.next() == Some(true);
        if !stays {
            targets.near[f.pixel as usize] = f.near;
        }
        stays
    });
}

/// By pixel, in image order: the surface exactly under its centre that is nearest to the eye, where it is nearer than the
/// stored depth `behind`. `reaching`: faces reach over the model's gaps; else only what lies under the centre itself counts.
fn nearest_hits(shader: &Shader, pixels: &[Filled], behind: Vec<f32>, reaching: bool) -> Vec<Option<Hit>> {
    if pixels.is_empty() {
        return Vec::new();
    }
    by_band(shader, pixels, &behind, |range, candidates| {
        let (pixels, behind) = (&pixels[range.clone()], &behind[range]);
        let mut hits: Vec<Option<Hit>> = behind.iter().map(|_| None).collect();
        let mut starts = Vec::new();
        for of_leaf in candidates.chunk_by(|a, b| a.leaf == b.leaf) {
            starts.clear();
            for near in of_leaf.chunk_by(|a, b| a.slot == b.slot) {
                add_starts(shader, near, &pixels[near[0].slot as usize], &mut starts);
            }
            search(shader, of_leaf[0].leaf, &starts, pixels, behind, reaching, &mut hits);
        }
        hits
    })
}

/// Where refinement begins.
struct Start {
    slot: u32,
    /// Its triangle, as a word without depth.
    triangle: u64,
    parameters: [f32; 2],
}

/// Whatever surface of a leaf lies under a pixel's centre, refinement finds it from a triangle nearby: from the nearest
/// point, and where the surface may fold over from the corners too.
fn add_starts(shader: &Shader, near: &[Candidate], of: &Filled, starts: &mut Vec<Start>) {
    let Tessellation { quads, deviation, .. } = shader.grids[near[0].leaf as usize];
    let first = starts.len();
    // What is found already: the leaf's point that the pixel shows.
    let shown = of.start.filter(|_| shader.meshlets.meshlets[meshlet_of(of.near) as usize].leaf == near[0].leaf);
    let is_new = |starts: &[Start], parameters: [f32; 2], apart: f32| {
        let known = starts[first..].iter().map(|s| s.parameters).chain(shown);
        let steps = |k: usize, s: [f32; 2]| (s[k] - parameters[k]).abs() * quads[k] as f32;
        !known.into_iter().any(|s| (0..2).all(|k| steps(k, s) <= apart))
    };
    for &Candidate { leaf, slot, word } in near {
        let parameters = shader.interpolated(leaf, word, of.pixel);
        if is_new(starts, parameters, POINTS_APART) {
            starts.push(Start { slot, triangle: word, parameters });
        }
        if !folds(shader, word, deviation[0]) {
            continue;
        }
        for parameters in corner_parameters(shader.meshlets, quads, word) {
            if is_new(starts, parameters, CORNERS_APART) {
                starts.push(Start { slot, triangle: word, parameters });
            }
        }
    }
}

/// The surface over a word's triangle may fold.
fn folds(shader: &Shader, word: u64, off: f32) -> bool {
    let meshlet = &shader.meshlets.meshlets[meshlet_of(word) as usize];
    let (Primitive::Triangle(corners) | Primitive::Edge(corners)) = primitive(meshlet, index_of(word));
    may_fold(&corners.map(|[i, j]| shader.meshlets.vertices[meshlet.vertex(i, j)]), off)
}

/// Refines the starts on one leaf and keeps, by slot, the nearest surface that is nearer than `behind`.
fn search(
    shader: &Shader,
    number: u32,
    starts: &[Start],
    pixels: &[Filled],
    behind: &[f32],
    reaching: bool,
    hits: &mut [Option<Hit>],
) {
    let surface = Surface { any_sheet: true, ..shader.surface(number) };
    let leaf = &shader.leaves[number as usize];
    let cut = Cut::new(shader.scene, shader.lens, shader.options, leaf);
    // Where the patch ends within the model's gap, its border stands in for what lies in it.
    let border = if reaching { trim_cut::gaps(shader.scene, shader.lens, leaf)[0] } else { 0.0 };
    let belongs = |batch: &Batch, k: usize| match &cut {
        Some(cut) if reaching => keeps(shader, number, cut, &surface, batch, k),
        Some(cut) => cut.tree.contains(cut.to_plane([batch.s[k], batch.t[k]].map(f64::from))),
        None => true,
    };
    let exact = (EXACT + border as f32).min(HALF_PIXEL);
    for starts in starts.chunks(LANES) {
        let mut batch = Batch::default();
        for k in 0..LANES {
            let start = &starts[k.min(starts.len() - 1)];
            [batch.s[k], batch.t[k]] = start.parameters;
            [batch.x[k], batch.y[k]] = shader.target(leaf, pixels[start.slot as usize].pixel);
        }
        shader.refine(&surface, 1, &mut batch);
        for (k, start) in starts.iter().enumerate().filter(|&(k, _)| batch.residual[k] <= exact) {
            let depth = shader.stored_depth(surface.depth_origin + batch.z[k]);
            let best = &mut hits[start.slot as usize];
            // Equal depths go to the larger word, as everywhere.
            let nearer = best.as_ref().is_none_or(|b| (depth, start.triangle) > (b.depth, b.triangle));
            let seen = nearer && depth > behind[start.slot as usize] && !batch.faces_away(k, leaf.hidden);
            if seen && belongs(&batch, k) {
                *best = Some(Hit { depth, triangle: start.triangle, parameters: [batch.s[k], batch.t[k]] });
            }
        }
    }
}
