//! evaluate by the GPU's kernels against evaluate by the CPU, on whole frames.

use halfpixel::cuda::evaluate::vertices;
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{ViewSpec, prepare};
use halfpixel::stages::{Bound, FrameShape, Options, Precision, Renderer};
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
                let found = vertices(&mut Device::new(schedule, 2), &staged).expect("no fault");
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
        let found = vertices(&mut Device::default(), &staged).expect("no fault");
        let off = staged.off(&found, &expected);
        assert!(off > 0.0 && off <= 1.0, "{name}, {precision:?}: {off} of what is allowed");
    }
    let tensor = ["evaluate_f16", "evaluate_f16_recovered", "evaluate_tf32", "evaluate_tf32_recovered"];
    assert!(tensor.iter().all(|name| kernels.contains(*name)), "{kernels:?}");
}
