//! What a grid says it is off by, against the surface between its vertices, in f64.

use crate::cuda::selection::Selection;
use crate::import::builtin::builtin;
use crate::scene::{Camera, Scene, View, ViewSpec, prepare};
use crate::stages::cull::{Culler, Leaf, Leaves};
use crate::stages::estimate::{Tessellation, estimate};
use crate::stages::lens::Lens;
use crate::stages::{Bound, Grid, Interpolation, Options};
use glam::DVec3;
use std::sync::atomic::AtomicU64;

const STEPS: u32 = 5;

/// Pixels and depth of the surface at leaf parameters.
fn place(scene: &Scene, lens: &Lens, leaf: &Leaf, s: [f64; 2]) -> DVec3 {
    let map = lens.patch_map(&scene.instances[leaf.instance as usize], scene.patches[leaf.patch as usize].origin);
    let p = map.apply(leaf.source(scene).0.position(s[0], s[1]).extend(1.0));
    DVec3::new(p.x / lens.denominator(p), p.y / lens.denominator(p), p.z / p.w)
}

/// The same on the triangle of a quad's corners at (a, b) in it, interpolated in space with the corners' weights.
fn on_triangle(lens: &Lens, corners: [(DVec3, f64); 4], diagonal: u8, [a, b]: [f64; 2]) -> DVec3 {
    // Corners (0,0), (1,0), (1,1), (0,1).
    let weights = match (diagonal, a >= b, a + b <= 1.0) {
        (0, true, _) => [1.0 - a, a - b, b, 0.0],
        (0, false, _) => [1.0 - b, 0.0, a, b - a],
        (_, _, true) => [1.0 - a - b, a, 0.0, b],
        _ => [0.0, 1.0 - b, a + b - 1.0, 1.0 - a],
    };
    let space = |p: DVec3| if lens.perspective { DVec3::new(p.x * p.z, p.y * p.z, p.z) } else { p };
    let w: f64 = (0..4).map(|k| corners[k].1 * weights[k]).sum();
    let p: DVec3 = (0..4).map(|k| space(corners[k].0) * (corners[k].1 * weights[k] / w)).sum();
    if lens.perspective { DVec3::new(p.x / p.z, p.y / p.z, p.z) } else { p }
}

/// Largest share of what a grid allows itself that it is off by, in pixels and in depth.
fn check(scene: &Scene, camera: &Camera, options: &Options) -> [f64; 2] {
    let lens = Lens::new(camera);
    let mut culler = Culler::new(scene, &lens, options, Selection::SINGLE);
    let mut leaves = Leaves::default();
    for (k, instance) in scene.instances.iter().enumerate() {
        for patch in instance.patches.clone() {
            culler.patch(k as u32, patch as u32, &mut leaves).expect("leaves");
        }
    }
    let (leaves, grids) = estimate(&mut culler, leaves, &AtomicU64::new(0)).expect("grids");
    let mut largest = [0.0f64; 2];
    for (leaf, grid) in leaves.leaves.iter().zip(&grids) {
        let Tessellation { quads, diagonal, deviation: [pixels, depth] } = *grid;
        assert!(f64::from(pixels) <= options.tolerance * (1.0 + 1e-6), "{pixels}");
        let quads = quads.map(|n| n.min(6));
        let at =
            |i: f64, j: f64| place(scene, &lens, leaf, [i / f64::from(grid.quads[0]), j / f64::from(grid.quads[1])]);
        let weight = |i: f64, j: f64| match options.bound.interpolation() {
            Interpolation::Affine => 1.0,
            Interpolation::Projective => {
                let (net, quads) = (leaf.source(scene).0, grid.quads);
                net.jet(i / f64::from(quads[0]), j / f64::from(quads[1])).point.w
            }
        };
        for (i, j) in (0..quads[0]).flat_map(|i| (0..quads[1]).map(move |j| (f64::from(i), f64::from(j)))) {
            let corner = |i: f64, j: f64| (at(i, j), weight(i, j));
            let corners = [corner(i, j), corner(i + 1.0, j), corner(i + 1.0, j + 1.0), corner(i, j + 1.0)];
            for (a, b) in (0..=STEPS).flat_map(|a| (0..=STEPS).map(move |b| (a, b))) {
                let [a, b] = [a, b].map(|c| f64::from(c) / f64::from(STEPS));
                let (exact, drawn) = (at(i + a, j + b), on_triangle(&lens, corners, diagonal, [a, b]));
                // What no pixel shows is not promised.
                if (0..2).any(|k| exact[k].abs() > lens.half(k)) {
                    continue;
                }
                let off = (exact - drawn).abs();
                let shares = [off.x.max(off.y) / f64::from(pixels), off.z / f64::from(depth).max(1e-300)];
                let rounding = 1e-9 * exact.z / f64::from(depth).max(1e-300);
                assert!(shares[0] <= 1.0 && shares[1] <= 1.0 + rounding, "{shares:?} {:?} patch {}", grid, leaf.patch);
                largest =
                    [0, 1].map(|k| largest[k].max(if off.z > 1e-9 * exact.z || k == 0 { shares[k] } else { 0.0 }));
            }
        }
    }
    largest
}

#[test]
fn surfaces_stay_within_what_their_grids_say() {
    let mut largest = [0.0f64; 2];
    for name in ["torus", "cylinder", "trimmed:ball", "trimmed:degree22", "trimmed:drilled"] {
        let model = builtin(name).expect("a built-in");
        let scene = prepare(&model, &|_, _| ()).expect("a scene");
        for (view, zoom, orthographic) in [(View::Iso, 1.0, false), (View::Top, 7.0, false), (View::Front, 2.0, true)] {
            let spec = ViewSpec { size: [320, 240], view, zoom, orthographic, ..ViewSpec::default() };
            let camera = spec.camera(&scene.bounds).expect("a camera");
            let bounds = [(Bound::Screen, 0.5), (Bound::Filip, 0.2), (Bound::Screen, 3.0), (Bound::Eter, 0.5)];
            for (bound, tolerance) in bounds {
                let options = Options { bound, tolerance, ..Options::default() };
                let found = check(&scene, &camera, &options);
                largest = [0, 1].map(|k| largest[k].max(found[k]));
            }
            let options = Options { bound: Bound::Eter, grid: Grid::Eter, ..Options::default() };
            check(&scene, &camera, &options);
        }
    }
    // The bound is sharp enough to be of use.
    assert!(largest.iter().all(|&share| share > 0.5), "{largest:?}");
}

#[test]
fn flat_faces_are_exact() {
    let scene = prepare(&builtin("trimmed:wedge").expect("a built-in"), &|_, _| ()).expect("a scene");
    let camera = ViewSpec { size: [320, 240], ..ViewSpec::default() }.camera(&scene.bounds).expect("a camera");
    let (lens, options) = (Lens::new(&camera), Options::default());
    let mut culler = Culler::new(&scene, &lens, &options, Selection::SINGLE);
    let mut leaves = Leaves::default();
    for patch in scene.instances[0].patches.clone().filter(|&p| scene.patches[p].degree == [1, 1]) {
        culler.patch(0, patch as u32, &mut leaves).expect("leaves");
    }
    let (_, grids) = estimate(&mut culler, leaves, &AtomicU64::new(0)).expect("grids");
    assert!(!grids.is_empty());
    for grid in grids {
        assert!(grid.deviation[0] < 0.01 && f64::from(grid.deviation[1]) < 1e-9, "{grid:?}");
    }
}
