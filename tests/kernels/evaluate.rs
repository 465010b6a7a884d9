//! evaluate by the GPU's kernels against evaluate by the CPU, on whole frames.

use halfpixel::cuda::abi::SUBPIXELS;
use halfpixel::cuda::precision::Hull;
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Bound, Options, Renderer};
use halfpixel::stages::{FrameShape, Precision};
use std::collections::BTreeSet;

/// All degrees up to 25, mixed ones, rational and polynomial, trimmed, split by a near plane; tiny, far away, degenerate.
const MODELS: [&str; 5] =
    ["builtin:teapot", "builtin:torus", "builtin:drum", "builtin:trimmed:drilled", "builtin:stress"];
/// One of each kernel for the same degree in u and v, and the one for any.
const KERNELS: usize = 8;

#[test]
fn evaluate_gives_the_same_words() {
    let mut kernels = BTreeSet::new();
    for name in MODELS {
        let model = import::load(name).expect("a model");
        let scene = prepare(&model, &|_, _| {}).expect("a scene");
        let renderer = Renderer::new(&scene);
        let views = [(false, Bound::Screen, 1.0), (true, Bound::Screen, 1.0), (false, Bound::Eter, 6.0)];
        for (orthographic, bound, zoom) in views {
            let view = ViewSpec { size: [160, 120], zoom, orthographic, ..ViewSpec::default() };
            let camera = view.camera(&scene.bounds).expect("a camera");
            let options = Options { bound, ..Options::default() };
            let (staged, expected) = renderer.staged(&camera, &options).expect("a frame");
            kernels.extend(staged.bins().into_iter().map(|(kernel, _)| kernel));
            for schedule in [Schedule::default(), Schedule::adversarial()[3]] {
                let found = Device::new(schedule, 2).evaluate(&staged).expect("no fault");
                assert!(!found.is_empty());
                assert_eq!(found, expected, "{name}, {bound:?}, orthographic: {orthographic}");
            }
        }
    }
    assert_eq!(kernels.len(), KERNELS, "{kernels:?}");
}

/// Where grids leave room for it, patches are evaluated in cheaper arithmetic, and no vertex is farther off than bounds say.
#[test]
fn cheaper_arithmetic_stays_within_its_bounds() {
    let mut kernels = BTreeSet::new();
    let cases = [
        ("builtin:teapot", 0.5, Precision::Auto),
        ("builtin:stress", 0.03, Precision::Auto),
        ("builtin:torus", 0.5, Precision::Tf32Recovered),
        ("builtin:stress", 0.5, Precision::F16Recovered),
        ("builtin:trimmed:drilled", 0.5, Precision::F16),
        ("builtin:torus", 0.5, Precision::Tf32),
    ];
    for (name, tolerance, precision) in cases {
        let model = import::load(name).expect("a model");
        let scene = prepare(&model, &|_, _| {}).expect("a scene");
        let view = ViewSpec { size: [160, 120], ..ViewSpec::default() };
        let camera = view.camera(&scene.bounds).expect("a camera");
        let options = Options { tolerance, precision, frame: FrameShape::Staged, ..Options::default() };
        let (staged, expected) = Renderer::new(&scene).staged(&camera, &options).expect("a frame");
        kernels.extend(staged.bins().into_iter().map(|(kernel, _)| kernel));
        let found = Device::default().evaluate(&staged).expect("no fault");
        for meshlet in &staged.meshlets {
            let patch = &staged.patches[meshlet.patch as usize];
            let net = &staged.nets[patch.net as usize..];
            let points = patch.degree.iter().map(|&d| usize::from(d) + 1).product();
            let hull = Hull::new(&staged.view, patch, &net[..points]);
            let bounds = [staged.arithmetic(meshlet.patch as usize), Default::default()].map(|a| a.bound(&hull));
            let off = SUBPIXELS as f64 * bounds.iter().map(|b| b.place).sum::<f64>() + 1.0;
            let vertices = meshlet.quads.iter().map(|&n| usize::from(n) + 1).product::<usize>();
            for k in (0..vertices).map(|k| meshlet.vertices as usize + k) {
                let [a, b] = [&found[k], &expected[k]];
                let apart = [a.x - b.x, a.y - b.y].map(|d| f64::from(d.abs()));
                assert!(apart.iter().all(|&d| d <= off), "{name}: {a:?}, {b:?}, {off} sub-pixels");
            }
        }
    }
    let tensor = ["evaluate_f16", "evaluate_f16_recovered", "evaluate_tf32", "evaluate_tf32_recovered"];
    assert!(tensor.iter().all(|name| kernels.contains(*name)), "{kernels:?}");
}
