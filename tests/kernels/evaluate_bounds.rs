//! The a-priori bounds of `cuda::precision` against f64, on nets made to come near them.

use crate::evaluate_scene::{DEPTH, Errors, Kind, Scene, Surface};
use crate::support::Random;
use halfpixel::cuda::precision::{Arithmetic, Bound};
use halfpixel::emulated::{Device, Schedule, TensorCores};

/// Patches of each scene.
const PATCHES: usize = 150;

/// How control points lie.
#[derive(Clone, Copy)]
enum Shape {
    /// Anywhere in the box.
    Anywhere,
    /// In its corners: the largest mean deviation.
    Corners,
    /// One in a corner, the others as near to the centre as 2^-30 of it: f16's subnormal numbers.
    Vanishing,
    /// All in one corner: the largest denominators' errors.
    Together,
}

const SHAPES: [Shape; 4] = [Shape::Anywhere, Shape::Corners, Shape::Vanishing, Shape::Together];
/// Weights lie between 1 / this and this.
const WEIGHTS: [f64; 4] = [1.0, 3.0, 30.0, 1000.0];
/// `|z - origin|` at most; 5 of 10 is a depth ratio of 3.
const RELIEFS: [f64; 3] = [0.01, 2.0, 5.0];

/// Largest and median part of the bound that errors reached: of place, depth and weight.
pub struct Tightness {
    pub largest: [f64; 3],
    pub median: [f64; 3],
}

/// Of one arithmetic, over all scenes and models of tensor cores. Fails where a bound doesn't hold.
pub fn tightness(arithmetic: Arithmetic) -> Tightness {
    let mut parts = [(); 3].map(|()| Vec::new());
    for kind in kinds() {
        let scene = hard_scene(kind);
        for tensor_cores in [TensorCores::Sm80, TensorCores::Sm90] {
            let mut device = Device::new(Schedule { tensor_cores, ..Schedule::default() }, 2);
            let kernel = arithmetic.kernel([1, 2]).to_string();
            let vertices = scene.evaluate(&mut device, &kernel);
            for (patch, found) in scene.errors_by_patch(&vertices).into_iter().enumerate() {
                let (hull, pixel) = scene.hull(patch);
                let bound = arithmetic.bound(&hull);
                let reached = reached(found, bound, pixel, scene.snapping());
                assert!(reached.iter().all(|&r| r <= 1.0), "{kernel} {kind:?} {hull:?}: {found:?}, {bound:?}, {pixel}");
                parts.iter_mut().zip(reached).for_each(|(parts, reached)| parts.push(reached));
            }
        }
    }
    parts.iter_mut().for_each(|p| p.sort_by(f64::total_cmp));
    let [largest, median] = [1, 2].map(|k| parts.each_ref().map(|p| p[p.len() / k - usize::from(k == 1)]));
    Tightness { largest, median }
}

fn reached(found: Errors, bound: Bound, pixel: f64, snapping: f64) -> [f64; 3] {
    [(found.px - snapping).max(0.0) / (bound.place * pixel), found.depth / bound.depth, found.weight / bound.weight]
}

/// From a pixel to 10,000, and both kinds of views.
fn kinds() -> impl Iterator<Item = Kind> {
    let widths = [1.0, 100.0, 10_000.0];
    widths.into_iter().flat_map(|width| [false, true].map(|perspective| Kind { rational: true, width, perspective }))
}

fn hard_scene(kind: Kind) -> Scene {
    let mut scene = Scene::new(kind);
    let mut random = Random(7);
    for k in 0..PATCHES {
        let degree = [(); 2].map(|()| 1 + random.below(7) as usize);
        let quads = [(); 2].map(|()| 1 + random.below(7) as usize);
        let net = hard_net(kind, degree, SHAPES[k % 4], WEIGHTS[k / 4 % 4], RELIEFS[k / 16 % 3], &mut random);
        scene.push_net(&Surface { degree, net: &net, quads, meshlets: &[([0, 0], quads)] });
    }
    scene
}

fn hard_net(
    kind: Kind,
    [m, n]: [usize; 2],
    shape: Shape,
    weights: f64,
    relief: f64,
    random: &mut Random,
) -> Vec<[f64; 4]> {
    let corner = [(); 3].map(|()| random.unit().signum());
    let points = (0..(m + 1) * (n + 1)).map(|k| {
        let place = corner.map(|c| match shape {
            Shape::Anywhere => random.unit(),
            Shape::Corners => random.unit().signum(),
            Shape::Vanishing if k > 0 => random.unit() * 0.5_f64.powi(random.below(30) as i32),
            Shape::Vanishing => c,
            Shape::Together => c * (1.0 - 1e-3 * random.unit().abs()),
        });
        let w = weights.powf(random.unit());
        let z = relief * place[2];
        let d = 0.5 * kind.width * w * if kind.perspective { DEPTH + z } else { 1.0 };
        [place[0] * d, place[1] * d, z * w, w]
    });
    points.collect()
}
