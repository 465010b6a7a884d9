//! Whether faces whose format says nothing of solids bound one: every border has its twin.

use crate::geometry::Net;
use crate::model::Part;
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// Control points nearer than this share of the part's size are the same.
const SAME: f64 = 1e-9;

/// True where each patch border that is not a point runs once in each direction, so that all patches face the same
/// way, and the faces' normals point outwards.
pub fn is_closed(part: &Part) -> bool {
    let patches = || part.faces.iter().flat_map(|f| &f.surface.patches).map(|p| p.patch.net());
    let (low, high) =
        patches().flat_map(|n| n.hull()).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let cell = (high - low).length() * SAME;
    if !(cell > 0.0 && cell.is_finite()) {
        return false;
    }
    let mut balance: HashMap<Vec<[i64; 4]>, i32> = HashMap::new();
    for net in patches() {
        for border in borders(net) {
            let key: Vec<[i64; 4]> = border.iter().map(|p| quantised(*p, low, cell)).collect();
            if key.iter().all(|k| k[..3] == key[0][..3]) {
                continue;
            }
            let reversed: Vec<[i64; 4]> = key.iter().rev().copied().collect();
            // The lexically smaller way round is the border's name; the other way counts against it.
            let (name, sign) = if key < reversed { (key, 1) } else { (reversed, -1) };
            *balance.entry(name).or_default() += sign;
        }
    }
    balance.values().all(|&b| b == 0) && volume(patches(), low * 0.5 + high * 0.5) > 0.0
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

/// A control point in cells about `low`, with its weight.
fn quantised(p: DVec4, low: DVec3, cell: f64) -> [i64; 4] {
    let q = (p.truncate() / p.w - low) / cell;
    // Two cells wide and rounded: twins that differ in the last bits almost always meet.
    [(q.x * 0.5).round() as i64, (q.y * 0.5).round() as i64, (q.z * 0.5).round() as i64, (p.w * 1e9).round() as i64]
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
