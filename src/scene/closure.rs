//! Whether faces whose format says nothing of solids bound one: every border has its twin.

use super::Sides;
use crate::geometry::Net;
use crate::model::Part;
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// Control points nearer than this share of the part's size are the same.
const SAME: f64 = 1e-6;
/// Share of the cube of the part's size below which a volume tells nothing.
const MIN_VOLUME: f64 = 1e-3;
/// Cells are this many times larger than that: few points lie near a cell's side.
const CELL: f64 = 64.0;

/// One side where each patch border that is not a point runs once in each direction: the patches bound a solid and all
/// face the same way.
pub fn visible_sides(part: &Part) -> Sides {
    let patches = || part.faces.iter().flat_map(|f| &f.surface.patches).map(|p| p.patch.net());
    let (low, high) =
        patches().flat_map(|n| n.hull()).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let size = (high - low).length();
    if !(size > 0.0 && size.is_finite()) {
        return Sides::Both;
    }
    let mut points = Points { cells: HashMap::new(), same: size * SAME, low, count: 0 };
    let mut balance: HashMap<Vec<u32>, i32> = HashMap::new();
    for border in patches().flat_map(borders) {
        let names: Vec<u32> = border.iter().map(|&p| points.name(p)).collect();
        if names.iter().all(|&n| n == names[0]) {
            continue;
        }
        let reversed: Vec<u32> = names.iter().rev().copied().collect();
        // The lexically smaller way round is the border's name; the other way counts against it.
        let (name, sign) = if names < reversed { (names, 1) } else { (reversed, -1) };
        *balance.entry(name).or_default() += sign;
    }
    if balance.values().any(|&b| b != 0) {
        return Sides::Both;
    }
    // Of thin shells the control nets' volume may err in sign: only a clear one counts.
    let volume = volume(patches(), low * 0.5 + high * 0.5) / size.powi(3);
    match volume {
        v if v > MIN_VOLUME => Sides::Outside,
        v if v < -MIN_VOLUME => Sides::Inside,
        _ => Sides::Both,
    }
}

/// Numbers for control points, the same for points that are nearly the same.
struct Points {
    cells: HashMap<[i64; 3], Vec<(DVec4, u32)>>,
    same: f64,
    low: DVec3,
    count: u32,
}

impl Points {
    fn name(&mut self, p: DVec4) -> u32 {
        let place = p.truncate() / p.w;
        let cell = |offset: DVec3| {
            let c = (place - self.low + offset) / (self.same * CELL);
            c.to_array().map(|c| c.floor() as i64)
        };
        // The cells that a box of radius `same` meets: one, but for points near a cell's side.
        let (first, last) = (cell(DVec3::splat(-self.same)), cell(DVec3::splat(self.same)));
        for x in first[0]..=last[0] {
            for y in first[1]..=last[1] {
                for z in first[2]..=last[2] {
                    let known = self.cells.get(&[x, y, z]).into_iter().flatten();
                    for &(q, name) in known {
                        let near = (q.truncate() - place).abs().max_element() <= self.same;
                        if near && (q.w / p.w - 1.0).abs() <= SAME {
                            return name;
                        }
                    }
                }
            }
        }
        let name = self.count;
        self.count += 1;
        let home = cell(DVec3::ZERO);
        self.cells.entry(home).or_default().push((place.extend(p.w), name));
        name
    }
}

/// The four border nets, so that the patch lies to the left of each.
fn borders(net: Net) -> [Vec<DVec4>; 4] {
    let [m, n] = net.degree();
    [
        (0..=m).map(|i| net.point(i, 0)).collect(),
        (0..=n).map(|j| net.point(m, j)).collect(),
        (0..=m).rev().map(|i| net.point(i, n)).collect(),
        (0..=n).rev().map(|j| net.point(0, j)).collect(),
    ]
}

/// Six times the volume that the control nets bound, about a point: its sign tells outside from inside.
fn volume<'a>(patches: impl Iterator<Item = Net<'a>>, center: DVec3) -> f64 {
    let mut sum = 0.0;
    for net in patches {
        let [m, n] = net.degree();
        let p = |i: usize, j: usize| {
            let q = net.point(i, j);
            q.truncate() / q.w - center
        };
        for i in 0..m {
            for j in 0..n {
                let (a, b, c, d) = (p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1));
                sum += a.dot(b.cross(c)) + a.dot(c.cross(d));
            }
        }
    }
    sum
}
