//! Part of prepare: what each face's loops leave of its patches.

use super::trim_tree::{Region, Trims};
use super::{ParameterBox, PatchTrim};
use crate::model::Face;
use rayon::prelude::*;

/// Faces a task looks at: a file of a few hundred must keep all threads busy.
const CHUNK: usize = 32;
/// Curves that come this near to a patch's border, as a share of its size, run along it: there is nothing to cut.
const ALONG: f64 = 1e-10;
/// The same for taking over a curve's gap: files are less exact than that.
const NEAR: f64 = 1e-6;

/// What the loops leave of every patch of every face, in order; `None`: nothing. Faces whose loops only run along their
/// patches' borders have no tree.
pub(super) fn trim_faces(faces: &[&Face]) -> (Trims, Vec<Option<PatchTrim>>) {
    let cut = faces.iter().any(|face| has_loops(face));
    let chunks: Vec<(Trims, Vec<Option<PatchTrim>>)> = faces
        .par_chunks(CHUNK)
        .map(|faces| {
            let mut trims = Trims::default();
            let patches = faces.iter().flat_map(|face| trim_face(face, cut, &mut trims)).collect();
            (trims, patches)
        })
        .collect();
    let mut all = Trims::default();
    let mut patches = Vec::with_capacity(chunks.iter().map(|(_, patches)| patches.len()).sum());
    for (trims, kept) in chunks {
        let offset = all.append(trims);
        let moved = |trim: PatchTrim| PatchTrim { tree: trim.tree.map(|tree| tree + offset), ..trim };
        patches.extend(kept.into_iter().map(|trim| trim.map(moved)));
    }
    all.shrink();
    (all, patches)
}

fn has_loops(face: &Face) -> bool {
    face.loops.iter().any(|l| !l.curves.is_empty())
}

/// A whole surface ends at its borders: where other faces are cut, one of these may come to meet it there.
fn whole_face(face: &Face, cut: bool) -> Vec<Option<PatchTrim>> {
    let patches = &face.surface.patches;
    let end = |axis: usize, of: fn(f64, f64) -> f64, k: usize| patches.iter().map(|p| p.domain[axis][k]).reduce(of);
    let ends = [0, 1].map(|axis| [end(axis, f64::min, 0), end(axis, f64::max, 1)]);
    let is_end = |d: &[[f64; 2]; 2], axis: usize, k: usize| ends[axis][k] == Some(d[axis][k]);
    let rim = |d: &[[f64; 2]; 2]| cut && (0..2).any(|axis| (0..2).any(|k| is_end(d, axis, k)));
    patches.iter().map(|p| Some(PatchTrim { rim: rim(&p.domain), ..PatchTrim::default() })).collect()
}

/// `cut`: loops cut some face of the model.
fn trim_face(face: &Face, cut: bool, trims: &mut Trims) -> Vec<Option<PatchTrim>> {
    if !has_loops(face) {
        return whole_face(face, cut);
    }
    let before = trims.mark();
    let number = trims.add(&face.loops);
    let tree = trims.tree(number);
    let trim_patch = |[u, v]: [[f64; 2]; 2]| {
        let domain = ParameterBox::around([[u[0], v[0]], [u[1], v[1]]]);
        let cut = match tree.classify(&domain.grown(margin(&domain, -ALONG))) {
            Region::Outside => return None,
            Region::Inside => false,
            Region::Boundary => true,
        };
        let by = margin(&domain, NEAR);
        let sides = [(0, true), (0, false), (1, true), (1, false)].map(|(axis, low)| {
            let mut side = domain;
            let end = if low { domain.low[axis] } else { domain.high[axis] };
            (side.low[axis], side.high[axis]) = (end, end);
            tree.gap_in(&side.grown(by))
        });
        let gap = sides.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
        Some(PatchTrim { tree: cut.then_some(number), rim: sides.iter().any(Option::is_some), gap })
    };
    let patches: Vec<Option<PatchTrim>> = face.surface.patches.iter().map(|p| trim_patch(p.domain)).collect();
    if patches.iter().flatten().all(|p| p.tree.is_none()) {
        trims.truncate(before);
    }
    patches
}

/// A share of a box's size, and what rounding of its coordinates takes.
fn margin(domain: &ParameterBox, share: f64) -> [f64; 2] {
    [0, 1].map(|k| {
        let (low, high) = (domain.low[k], domain.high[k]);
        share * (high - low) + share.signum() * 4.0 * f64::EPSILON * low.abs().max(high.abs())
    })
}
