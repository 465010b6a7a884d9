//! Which borders of patches coincide: those whose control points do, read in either direction.

use crate::cuda::abi;
use crate::scene::{Patch, Scene};
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// The borders of a scene's patches: one number for all that coincide.
#[derive(Clone, Debug)]
pub struct Borders {
    /// By patch and side (u=0, u=1, v=0, v=1).
    sides: Vec<[Side; 4]>,
}

/// A border and the direction in which a patch runs along it.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    border: u32,
    reversed: bool,
}

/// Where a leaf ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Line {
    /// At a border of its patch.
    Border(u32),
    /// Where the patch was split: patch, axis that the line runs along, the other parameter.
    Split(u32, usize, u64),
}

/// Points that are this close, in parts of the scene's size, are one: nets are kept about origins of their own, and so rounded.
const CLOSE: f64 = 1e-10;
/// Steps in which weights are told apart, relative to the largest of a border.
const WEIGHTS: f64 = (1 << 20) as f64;

impl Borders {
    pub fn new(scene: &Scene) -> Self {
        let mut weld = Weld::new(scene);
        let mut borders: HashMap<Vec<(u32, u32)>, u32> = HashMap::new();
        let mut side = |points: Vec<(u32, u32)>| {
            let mut back = points.clone();
            back.reverse();
            let reversed = back < points;
            let next = borders.len() as u32;
            Side { border: *borders.entry(if reversed { back } else { points }).or_insert(next), reversed }
        };
        let sides = (scene.patches.iter())
            .map(|patch| [0, 1, 2, 3].map(|k| side(weld.named(patch, &border(scene, patch, k)))))
            .collect();
        Self { sides }
    }

    /// Names for the sides of a view's patches, as `EdgeFactors::Shared` takes them. A border that one of two neighbours was
    /// split along has two names: factors of its parts do not meet.
    pub fn sides(&self, patches: &[abi::Patch], leaves: &[abi::Leaf]) -> Vec<[u32; 4]> {
        let mut names = HashMap::new();
        let mut name = |key: (u32, Line, [u64; 2])| {
            let next = names.len() as u32;
            *names.entry(key).or_insert(next)
        };
        let named = |(patch, leaf): (&abi::Patch, &abi::Leaf)| {
            [0, 1, 2, 3].map(|k| {
                let (line, ends) = self.line(patch.source, leaf, k);
                name((patch.instance, line, ends.map(f64::to_bits)))
            })
        };
        patches.iter().zip(leaves).map(named).collect()
    }

    /// The line that a side of a leaf lies on, and where on it. Leaves come of halving: their corners are exact.
    fn line(&self, source: u32, leaf: &abi::Leaf, k: usize) -> (Line, [f64; 2]) {
        let (across, along) = (k / 2, 1 - k / 2);
        let low = leaf.corner;
        let high = [0, 1].map(|axis| low[axis] + leaf.extent[axis]);
        let (place, end) = if k.is_multiple_of(2) { (low[across], 0.0) } else { (high[across], 1.0) };
        let ends = [low[along], high[along]];
        match self.sides.get(source as usize) {
            Some(sides) if place == end => {
                let Side { border, reversed } = sides[k];
                (Line::Border(border), if reversed { [1.0 - ends[1], 1.0 - ends[0]] } else { ends })
            }
            _ => (Line::Split(source, along, place.to_bits()), ends),
        }
    }
}

/// The control points of a side.
fn border(scene: &Scene, patch: &Patch, side: usize) -> Vec<DVec4> {
    let [m, n] = patch.degree;
    let net = &scene.points[patch.points.clone()];
    let at = |i: usize, j: usize| net[i * (n + 1) + j];
    match side {
        0 => (0..=n).map(|j| at(0, j)).collect(),
        1 => (0..=n).map(|j| at(m, j)).collect(),
        2 => (0..=m).map(|i| at(i, 0)).collect(),
        _ => (0..=m).map(|i| at(i, n)).collect(),
    }
}

/// Names for points: close ones have the same.
struct Weld {
    cell: f64,
    cells: HashMap<[i64; 3], Vec<(DVec3, u32)>>,
    count: u32,
}

impl Weld {
    fn new(scene: &Scene) -> Self {
        let size = scene.patches.iter().map(|p| p.origin.abs().max_element() + p.radius).fold(0.0, f64::max);
        // Never 0: a scene of one point has one cell.
        Self { cell: (2.0 * CLOSE * size).max(f64::MIN_POSITIVE), cells: HashMap::new(), count: 0 }
    }

    /// Names of a border's points, with their weights.
    fn named(&mut self, patch: &Patch, points: &[DVec4]) -> Vec<(u32, u32)> {
        let most = points.iter().map(|p| p.w).fold(0.0, f64::max);
        let weight = |p: &DVec4| (p.w / most * WEIGHTS).round() as u32;
        points.iter().map(|p| (self.name(patch.origin + p.truncate() / p.w), weight(p))).collect()
    }

    fn name(&mut self, point: DVec3) -> u32 {
        let scaled = point / self.cell;
        // All cells that a point within half a cell may be in.
        let low = (scaled - 0.5).floor();
        for corner in 0..8 {
            let cell = [0, 1, 2].map(|axis| low[axis] as i64 + (corner >> axis & 1));
            let close = |(other, _): &&(DVec3, u32)| (*other - point).abs().max_element() <= 0.5 * self.cell;
            if let Some((_, name)) = self.cells.get(&cell).and_then(|all| all.iter().find(close)) {
                return *name;
            }
        }
        let name = self.count;
        self.count += 1;
        self.cells.entry(scaled.floor().to_array().map(|c| c as i64)).or_default().push((point, name));
        name
    }
}
