//! estimate: the grid of each leaf from its bound (DESIGN section 4; ETER's TFE).

use super::bounds::{Constraints, Subject, constraints, deviation, small_triangles};
use super::cull::{Culler, Leaf, Leaves};
use super::{Grid, RenderError};
use glam::Vec4;
use std::sync::atomic::{AtomicU64, Ordering};

/// Half a sub-pixel step: what snapping a vertex to 1/256 pixel may move it.
const SNAPPING: f64 = 1.0 / 512.0;
/// Quads along one side of a meshlet: 8 x 8 vertices.
pub(super) const MESHLET: u32 = crate::cuda::abi::MESHLET_VERTICES - 1;
/// Quads a leaf may have along one side; it is split beyond.
const MAX_SIDE: u32 = 1 << 12;
/// Quads a leaf may have in all; it is split beyond, so that what is off screen is culled.
const MAX_QUADS: u64 = 1 << 14;
/// Largest part of a leaf's quads that its halves may have to be drawn instead: they bring strokes of their own.
const HALVES_KEPT: f64 = 0.875;
/// Halvings that may save nothing before one that does.
const LOOK_AHEAD: u32 = 1;
/// Vertices of all grids together, 16 bytes each: 4 GiB.
pub(super) const MAX_VERTICES: u64 = 1 << 28;
/// Splitting can't mend a grid once a leaf is this small a part of its patch.
const MAX_DEPTH: u32 = 40;

/// The grid of one leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tessellation {
    pub quads: [u32; 2],
    /// 0: (0,0)-(1,1); 1: (1,0)-(0,1).
    pub diagonal: u8,
    /// What the grid is really off by at most, parameter by parameter: at most the tolerance, and next to nothing on flat
    /// patches. Pixels, snapping and rounding included, and camera depth in model units.
    pub deviation: [f32; 2],
}

impl Tessellation {
    /// Meshlets of at most 7 x 7 quads that the grid needs.
    pub fn meshlets(&self) -> u64 {
        self.quads.iter().map(|&n| u64::from(n.div_ceil(MESHLET))).product()
    }

    fn all_quads(&self) -> u64 {
        u64::from(self.quads[0]) * u64::from(self.quads[1])
    }

    /// Vertices of these meshlets; neighbours repeat their common ones.
    fn vertices(&self) -> u64 {
        self.quads.iter().map(|&n| u64::from(n + n.div_ceil(MESHLET))).product()
    }
}

/// Leaves with their grids.
#[derive(Default)]
struct Gridded {
    leaves: Leaves,
    grids: Vec<Tessellation>,
    quads: u64,
}

impl Gridded {
    fn push(&mut self, mut leaf: Leaf, net: &[Vec4], grid: Tessellation) {
        leaf.net = self.leaves.nets.len() as u32;
        self.leaves.nets.extend_from_slice(net);
        self.leaves.leaves.push(leaf);
        self.grids.push(grid);
        self.quads += grid.all_quads();
    }

    fn vertices(&self) -> u64 {
        self.grids.iter().map(Tessellation::vertices).sum()
    }

    fn append(&mut self, other: Gridded) {
        for (leaf, grid) in other.leaves.leaves.into_iter().zip(other.grids) {
            let net = leaf.net as usize..leaf.net as usize + leaf.points();
            self.push(leaf, &other.leaves.nets[net], grid);
        }
    }
}

/// Gives every leaf its grid; leaves whose grid would be too large, or that need fewer quads in two, are split and culled
/// again. `vertices` counts those of all tasks.
pub(super) fn estimate(
    culler: &mut Culler,
    leaves: Leaves,
    vertices: &AtomicU64,
) -> Result<(Leaves, Vec<Tessellation>), RenderError> {
    let mut done = Gridded::default();
    done.leaves.patches_visible = leaves.patches_visible;
    settle(culler, leaves, vertices, &mut done)?;
    Ok((done.leaves, done.grids))
}

/// Appends the leaves with their grids, or the halves that a grid needs.
fn settle(culler: &mut Culler, from: Leaves, vertices: &AtomicU64, done: &mut Gridded) -> Result<(), RenderError> {
    for leaf in from.leaves {
        let net = &from.nets[leaf.net as usize..leaf.net as usize + leaf.points()];
        match grid_of(culler, &leaf, net)? {
            Ok(grid) => {
                let halves = cheaper_halves(culler, &leaf, grid, LOOK_AHEAD);
                // Before anything is kept: a tolerance that asks for too much must not fill the memory first.
                let count = halves.as_ref().map_or(grid.vertices(), Gridded::vertices);
                if vertices.fetch_add(count, Ordering::Relaxed) + count > MAX_VERTICES {
                    return Err(RenderError::TooManyVertices { limit: MAX_VERTICES });
                }
                match halves {
                    Some(halves) => done.append(halves),
                    None => done.push(leaf, net, grid),
                }
            }
            Err(axis) => {
                let mut halves = Leaves::default();
                culler.split_leaf(&leaf, axis, &mut halves)?;
                settle(culler, halves, vertices, done)?;
            }
        }
    }
    Ok(())
}

/// A large leaf's parts, where their own bounds, and what the image shows of them, ask for clearly fewer quads. What can't be
/// had is no error: the leaf itself stands. `tries` more halvings may pass without a gain.
fn cheaper_halves(culler: &mut Culler, leaf: &Leaf, grid: Tessellation, tries: u32) -> Option<Gridded> {
    let rational = culler.scene.patches[leaf.patch as usize].rational;
    let too_small = grid.all_quads() < worth_halving(leaf.points() as u64, rational);
    if culler.options.grid != Grid::Adaptive || too_small || leaf.depth >= MAX_DEPTH {
        return None;
    }
    let mut halves = Leaves::default();
    culler.split_leaf(leaf, usize::from(grid.quads[1] > grid.quads[0]), &mut halves).ok()?;
    let net = |half: &Leaf| half.net as usize..half.net as usize + half.points();
    let own_grid = |half: &Leaf| grid_of(culler, half, &halves.nets[net(half)]).ok()?.ok();
    let grids: Vec<Tessellation> = halves.leaves.iter().map(own_grid).collect::<Option<_>>()?;
    let fewer = |quads: u64| quads as f64 <= grid.all_quads() as f64 * HALVES_KEPT;
    let gained = fewer(grids.iter().map(Tessellation::all_quads).sum());
    // Each gain leaves fewer quads for all that follow, so that this ends early where halving is of no use.
    let tries = if gained { LOOK_AHEAD } else { tries.checked_sub(1)? };
    let mut parts = Gridded::default();
    for (half, grid) in halves.leaves.into_iter().zip(grids) {
        match cheaper_halves(culler, &half, grid, tries) {
            Some(quarters) => parts.append(quarters),
            None => {
                let net = net(&half);
                parts.push(half, &halves.nets[net], grid);
            }
        }
    }
    fewer(parts.quads).then_some(parts)
}

/// Quads from which on a leaf's halves are tried: enclosing two of them takes about as long as drawing these. Splitting takes
/// some multiple of the control points, the products in a rational patch's derivatives a multiple of their square.
fn worth_halving(points: u64, rational: bool) -> u64 {
    if rational { 12 * points * points } else { 16 * points }
}

/// The leaf's grid, or the axis to split where it would be too large.
fn grid_of(culler: &Culler, leaf: &Leaf, projected: &[Vec4]) -> Result<Result<Tessellation, usize>, RenderError> {
    let Culler { scene, lens, options, .. } = *culler;
    let [rounding, depth_rounding] = leaf.evaluation;
    let tolerance = options.tolerance - SNAPPING - rounding;
    if tolerance <= 0.0 {
        return Err(RenderError::ToleranceTooSmall { tolerance: options.tolerance, floor: SNAPPING + rounding });
    }
    let (net, enclosure) = leaf.source(scene);
    let patch = &scene.patches[leaf.patch as usize];
    let map = lens.patch_map(&scene.instances[leaf.instance as usize], patch.origin);
    let subject = Subject {
        leaf,
        lens,
        map: &map,
        net,
        enclosure,
        projected,
        tolerance,
        depth_tolerance: options.depth_tolerance * lens.pixel_size(leaf.low.z) - depth_rounding,
    };
    let constraints = constraints(options.bound, &subject);
    let Some(mut grid) = solve(&constraints) else {
        return too_large(culler, leaf, &constraints);
    };
    grid.deviation = [options.tolerance, subject.depth_tolerance + depth_rounding].map(|d| d as f32);
    if options.grid == Grid::Eter16 {
        let least = small_triangles(&subject);
        if least[0].max(least[1]) > f64::from(MAX_SIDE) {
            return split_along(culler, leaf, least);
        }
        grid.quads = [0, 1].map(|k| grid.quads[k].max(least[k] as u32));
    }
    if matches!(options.grid, Grid::Eter | Grid::Eter16) {
        grid.quads = grid.quads.map(|n| n.next_multiple_of(MESHLET));
    }
    if grid.all_quads() > MAX_QUADS {
        return match options.grid {
            Grid::Eter16 => split_along(culler, leaf, grid.quads.map(f64::from)),
            _ => too_large(culler, leaf, &constraints),
        };
    }
    if let Some([pixels, depth]) = deviation(options.bound, &subject, &constraints, &grid) {
        let least = |real: f64, allowed: f64| if real < allowed { real } else { allowed };
        let pixels = SNAPPING + rounding + least(pixels, tolerance);
        let depth = depth_rounding + least(depth, subject.depth_tolerance);
        grid.deviation = [pixels, depth].map(|d| (d as f32).next_up());
    }
    Ok(Ok(grid))
}

fn too_large(
    culler: &Culler,
    leaf: &Leaf,
    constraints: &Constraints,
) -> Result<Result<Tessellation, usize>, RenderError> {
    let worst = |k: usize| constraints.of(0).iter().map(|c| c[k]).fold(0.0, f64::max);
    split_along(culler, leaf, [worst(0), worst(2)])
}

/// Where a leaf is to be split: across what is worse along u and v.
fn split_along(culler: &Culler, leaf: &Leaf, worst: [f64; 2]) -> Result<Result<Tessellation, usize>, RenderError> {
    if leaf.depth >= MAX_DEPTH {
        let face = culler.scene.patches[leaf.patch as usize].face;
        let id = culler.scene.faces[face as usize].id;
        return Err(RenderError::GridTooLarge { face: id, patch: leaf.patch, limit: MAX_QUADS });
    }
    Ok(Err(usize::from(worst[1] > worst[0])))
}

/// The fewest quads that satisfy all constraints of one diagonal; `None` above `MAX_SIDE`.
pub(super) fn solve(constraints: &Constraints) -> Option<Tessellation> {
    let candidates = [0u8, 1].map(|diagonal| solve_one(constraints.of(diagonal.into())).map(|quads| (quads, diagonal)));
    let area = |quads: [u32; 2]| u64::from(quads[0]) * u64::from(quads[1]);
    let best = candidates.into_iter().flatten().min_by_key(|&(quads, diagonal)| (area(quads), diagonal))?;
    Some(Tessellation { quads: best.0, diagonal: best.1, deviation: [f32::INFINITY; 2] })
}

fn solve_one(constraints: &[[f64; 3]]) -> Option<[u32; 2]> {
    if constraints.iter().all(|[a, b, c]| a + b + c <= 1.0) {
        return Some([1, 1]);
    }
    let least = |k: usize| {
        let largest = constraints.iter().map(|c| c[k]).fold(0.0, f64::max);
        largest.sqrt().ceil().max(1.0)
    };
    let (first, floor) = (least(0), least(2));
    if !(first <= f64::from(MAX_SIDE) && floor <= f64::from(MAX_SIDE)) {
        return None;
    }
    let mut best: Option<[u32; 2]> = None;
    let mut nu = first;
    // nv falls as nu grows, down to `floor`: beyond best / floor no area can be smaller.
    while nu <= f64::from(MAX_SIDE) {
        let area = best.map_or(f64::INFINITY, |[u, v]| f64::from(u) * f64::from(v));
        if nu * floor >= area {
            break;
        }
        let nv = fewest_across(constraints, nu);
        if nv * nu < area && nv <= f64::from(MAX_SIDE) {
            best = Some([nu as u32, nv as u32]);
        }
        nu += 1.0;
    }
    best
}

/// The smallest nv for a given nu: the larger root of `(1 - a/nu^2) nv^2 - (b/nu) nv - c = 0`.
fn fewest_across(constraints: &[[f64; 3]], nu: f64) -> f64 {
    let mut nv = 1.0f64;
    for &[a, b, c] in constraints {
        let s = 1.0 - a / (nu * nu);
        let b = b / nu;
        if s > 0.0 {
            // Most constraints hold already where the few that bind have been met: no root is needed.
            if (s * nv - b) * nv < c {
                nv = nv.max((b + (b * b + 4.0 * s * c).sqrt()) / (2.0 * s));
            }
        } else if b > 0.0 || c > 0.0 || s < 0.0 {
            return f64::INFINITY;
        }
    }
    // A root that is a whole number but for rounding: one part in 10^12 is far inside the tolerance.
    (nv * (1.0 - 1e-12)).ceil()
}
