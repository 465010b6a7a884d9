//! Martin Newell's teapot of 1975, with the bottom that was added later: 32 bicubic patches.

use super::part;
use crate::geometry::BezierPatch;
use crate::model::{Part, Solidity, Surface};
use glam::DVec4;

/// Profiles of the round parts: four rows of (radius, tangent length, z). Each makes four quarter turns.
const ROUND: [[[f64; 3]; 4]; 6] = [
    // Rim.
    [[1.4, 0.784, 2.4], [1.3375, 0.749, 2.53125], [1.4375, 0.805, 2.53125], [1.5, 0.84, 2.4]],
    // Body, upper and lower.
    [[1.5, 0.84, 2.4], [1.75, 0.98, 1.875], [2.0, 1.12, 1.35], [2.0, 1.12, 0.9]],
    [[2.0, 1.12, 0.9], [2.0, 1.12, 0.45], [1.5, 0.84, 0.225], [1.5, 0.84, 0.15]],
    // Lid, knob and cover. The odd 0.45 is Newell's.
    [[0.0, 0.0, 3.15], [0.8, 0.45, 3.15], [0.0, 0.0, 2.85], [0.2, 0.112, 2.7]],
    [[0.2, 0.112, 2.7], [0.4, 0.224, 2.55], [1.3, 0.728, 2.55], [1.3, 0.728, 2.4]],
    // Bottom, the only one from the centre outward: it turns the other way.
    [[0.0, 0.0, 0.0], [1.425, 0.798, 0.0], [1.5, 0.84, 0.075], [1.5, 0.84, 0.15]],
];

/// Halves of handle and spout: four rows of (x, z, x, z, half width), the two (x, z) on the plane of symmetry.
const BENT: [[[f64; 5]; 4]; 4] = [
    // Handle.
    [[-1.6, 2.025, -1.5, 2.25, 0.3], [-2.3, 2.025, -2.5, 2.25, 0.3], [-2.7, 2.025, -3.0, 2.25, 0.3], HANDLE],
    [HANDLE, [-2.7, 1.575, -3.0, 1.35, 0.3], [-2.5, 1.125, -2.65, 0.9375, 0.3], [-2.0, 0.9, -1.9, 0.6, 0.3]],
    // Spout.
    [[1.7, 1.425, 1.7, 0.6, 0.66], [2.6, 1.425, 3.1, 0.825, 0.66], [2.3, 2.1, 2.4, 2.025, 0.25], SPOUT],
    [SPOUT, [2.8, 2.475, 3.525, 2.49375, 0.25], [2.9, 2.475, 3.45, 2.5125, 0.15], [2.8, 2.4, 3.2, 2.4, 0.15]],
];
const HANDLE: [f64; 5] = [-2.7, 1.8, -3.0, 1.8, 0.3];
const SPOUT: [f64; 5] = [2.7, 2.4, 3.3, 2.4, 0.25];

/// The teapot: an open surface (spout and lid let one see inside), a face a patch.
pub fn teapot() -> Part {
    let round = ROUND.iter().enumerate().flat_map(|(k, rows)| quarters(rows, if k == 5 { 1.0 } else { -1.0 }));
    let bent = BENT.iter().flat_map(halves);
    let surface = |points: Vec<DVec4>| Surface::single(BezierPatch::from_points([3, 3], points));
    part("teapot", Solidity::Open, round.chain(bent).map(surface).collect())
}

/// Four patches about the z axis; `sense` 1 is counterclockwise.
fn quarters(rows: &[[f64; 3]; 4], sense: f64) -> Vec<Vec<DVec4>> {
    let quarter = |turns: usize| {
        let point = |x: f64, y: f64, z: f64| {
            let [x, y] = (0..turns).fold([x, y], |[x, y], _| [-sense * y, sense * x]);
            // Adding zero takes the sign off a zero.
            DVec4::new(x + 0.0, y + 0.0, z, 1.0)
        };
        let row = |&[r, k, z]: &[f64; 3]| {
            [point(r, 0.0, z), point(r, sense * k, z), point(k, sense * r, z), point(0.0, sense * r, z)]
        };
        rows.iter().flat_map(row).collect()
    };
    (0..4).map(quarter).collect()
}

/// The half at y < 0 and its mirror image, run through from the other side so that the two face the same way.
fn halves(rows: &[[f64; 5]; 4]) -> Vec<Vec<DVec4>> {
    let row = |x0: f64, z0: f64, x1: f64, z1: f64, y: f64| {
        [[x0, 0.0, z0], [x0, y, z0], [x1, y, z1], [x1, 0.0, z1]].map(|[x, y, z]| DVec4::new(x, y, z, 1.0))
    };
    let near = rows.iter().flat_map(|&[x0, z0, x1, z1, y]| row(x0, z0, x1, z1, -y)).collect();
    let far = rows.iter().flat_map(|&[x0, z0, x1, z1, y]| row(x1, z1, x0, z0, y)).collect();
    vec![near, far]
}

#[cfg(test)]
mod tests {
    use super::teapot;
    use glam::DVec3;

    /// The same patches as `teapot.bpt` in `$HALFPIXEL_MODELS` or ../shared/models, in any order; skipped without it.
    #[test]
    fn the_patches_are_newells() {
        let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/models").to_string();
        let folder = std::env::var("HALFPIXEL_MODELS").unwrap_or(beside);
        let Ok(text) = std::fs::read_to_string(format!("{folder}/teapot.bpt")) else {
            eprintln!("skipped: there is no {folder}/teapot.bpt (set HALFPIXEL_MODELS)");
            return;
        };
        let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        // The number of patches, then per patch its degrees and 16 points.
        let mut theirs: Vec<Vec<f64>> = numbers[1..].chunks_exact(50).map(|patch| patch[2..].to_vec()).collect();
        assert_eq!(theirs.len(), 32);
        for face in &teapot().faces {
            let hull: Vec<DVec3> = face.surface.patches[0].patch.net().hull().collect();
            let ours: Vec<f64> = hull.iter().flat_map(|p| p.to_array()).collect();
            let found = theirs.iter().position(|patch| *patch == ours);
            theirs.swap_remove(found.unwrap_or_else(|| panic!("{} is not in the file: {ours:?}", face.name)));
        }
    }
}
