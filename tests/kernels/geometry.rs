//! cull, estimate and the list of meshlets by kernels against the CPU's, word for word.

use crate::support::under_all_schedules;
use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use halfpixel::cuda::abi;
use halfpixel::cuda::evaluate::Staged;
use halfpixel::cuda::precision::Arithmetic;
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{Scene, SceneInstance, ViewSpec, prepare};
use halfpixel::stages::{Bound, Cull, FrameShape, GeometryCounts, Grid, Options, Precision, Renderer, Trim};
use std::collections::BTreeMap;
use std::mem::discriminant;
use std::ops::Range;

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// Lists of a frame, by name: a difference is told by the list and its first entry that differs.
fn compare(found: &Staged, expected: &Staged, what: &str) {
    macro_rules! same {
        ($($list:ident)*) => { $(
            let differs = found.$list.iter().zip(&expected.$list).position(|(a, b)| a != b);
            if let Some(k) = differs {
                panic!("{what}: {} {k}: {:#?} not {:#?}", stringify!($list), found.$list[k], expected.$list[k]);
            }
            assert_eq!(found.$list.len(), expected.$list.len(), "{what}: {}", stringify!($list));
        )* };
    }
    same!(patches leaves nets basis meshlets);
    assert_eq!(found.vertices, expected.vertices, "{what}");
}

fn check(scene: &Scene, view: ViewSpec, options: Options, what: &str) -> Staged {
    let renderer = Renderer::new(scene);
    let camera = view.camera(&scene.bounds).expect("a camera");
    let (expected, _) = renderer.staged(&camera, &options).expect("a frame");
    for schedule in [Schedule::default(), Schedule::adversarial()[3]] {
        let (found, _) = renderer.staged_on(&mut Device::new(schedule, 2), &camera, &options).expect("a frame");
        compare(&found, &expected, &format!("{what}, {view:?}, {options:?}"));
    }
    expected
}

const MODELS: [&str; 6] =
    ["builtin:teapot", "builtin:sphere", "builtin:torus", "builtin:drum", "builtin:trimmed:drilled", "builtin:stress"];

fn view(orthographic: bool, zoom: f64) -> ViewSpec {
    ViewSpec { size: [160, 120], zoom, orthographic, ..ViewSpec::default() }
}

/// What the tests below have come by.
#[derive(Debug, Default)]
struct Met {
    parts: usize,
    rational_parts: usize,
    deep: usize,
    tested: usize,
    untested_of_trimmed: usize,
    hidden: usize,
    blocks: usize,
}

impl Met {
    fn add(&mut self, staged: &Staged) {
        let part = |l: &&abi::Leaf| l.extent != [1.0; 2];
        self.parts += staged.leaves.iter().filter(part).count();
        self.rational_parts += staged.leaves.iter().filter(part).filter(|l| l.rational != 0).count();
        self.deep += staged.leaves.iter().filter(|l| l.extent[0] * l.extent[1] < 1e-3).count();
        self.tested += staged.meshlets.iter().filter(|m| m.tested != 0).count();
        let trimmed = |m: &&abi::Meshlet| staged.leaves[m.patch as usize].tree != abi::NO_TREE;
        self.untested_of_trimmed += staged.meshlets.iter().filter(trimmed).filter(|m| m.tested == 0).count();
        self.hidden += staged.patches.iter().filter(|p| p.hidden != 0).count();
        self.blocks += staged.meshlets.iter().filter(|m| m.outer == 0).count();
    }
}

#[test]
fn geometry_is_the_cpus() {
    let mut met = Met::default();
    for name in MODELS {
        let scene = scene(name);
        for (orthographic, zoom) in [(false, 1.0), (true, 1.0), (false, 6.0), (true, 40.0)] {
            met.add(&check(&scene, view(orthographic, zoom), Options::default(), name));
        }
    }
    assert!(met.parts > 100 && met.hidden > 100 && met.tested > 0 && met.blocks > 1000, "{met:?}");
}

/// Grids so large that they are halved: for being too large, and for fewer quads.
#[test]
fn large_grids_are_halved_alike() {
    let mut met = Met::default();
    let fine = Options { tolerance: 0.02, depth_tolerance: 0.05, ..Options::default() };
    for name in ["builtin:teapot", "builtin:torus", "builtin:trimmed:drilled", "builtin:stress:degree25"] {
        let scene = scene(name);
        for (zoom, options) in [(1.0, fine), (9.0, fine), (60.0, Options::default())] {
            met.add(&check(&scene, ViewSpec { size: [640, 480], ..view(false, zoom) }, options, name));
        }
    }
    assert!(met.parts > 500 && met.rational_parts > 100, "{met:?}");
}

/// Trim curves over curved grids: blocks are dropped before and after they are evaluated.
#[test]
fn trimmed_grids_are_cut_alike() {
    let mut met = Met::default();
    let fine = Options { tolerance: 0.1, depth_tolerance: 0.1, ..Options::default() };
    for name in ["plate", "wedge", "gap", "ball", "bowl", "degree22", "touching"] {
        let scene = scene(&format!("builtin:trimmed:{name}"));
        for (zoom, options) in [(1.0, fine), (5.0, fine), (1.0, Options { trim: Trim::Off, ..fine })] {
            met.add(&check(&scene, ViewSpec { size: [640, 480], ..view(false, zoom) }, options, name));
        }
    }
    assert!(met.tested > 100 && met.untested_of_trimmed > 100, "{met:?}");
}

/// Instances that are turned, mirrored, stretched, coloured as a whole and by face; one draws nothing.
#[test]
fn instances_are_drawn_alike() {
    for name in ["builtin:drum", "builtin:trimmed:wedge"] {
        let mut scene = scene(name);
        let mut place = |transform: DAffine3, color, faces: &[u32], patches: Range<usize>| {
            let mut instance = scene.instances[0].clone();
            instance.face_colors = faces.iter().map(|&face| (face, [0.1, 0.2, face as f32])).collect();
            scene.instances.push(SceneInstance { transform, color, patches, ..instance });
        };
        let all = 0..scene.patches.len();
        let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7);
        let moved = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.3, -x));
        place(moved(0.5), None, &[], 0..0);
        place(moved(1.0) * turned, Some([0.5, 0.25, 0.0]), &[], all.clone());
        place(moved(-1.5) * DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)), None, &[0, 2], all.clone());
        place(DAffine3::from_scale(DVec3::new(0.2, 2.0, 0.7)) * turned, Some([1.0; 3]), &[1], 1..all.end);
        for orthographic in [false, true] {
            let staged = check(&scene, view(orthographic, 1.0), Options::default(), name);
            assert!(staged.patches.iter().any(|p| p.hidden > 0) && staged.patches.iter().any(|p| p.hidden < 0));
        }
    }
}

/// Frames that can't be had end with the CPU's own words.
#[test]
fn errors_are_the_cpus() {
    let stopped = |name: &str, view: ViewSpec, options: Options| {
        let scene = scene(name);
        let renderer = Renderer::new(&scene);
        let camera = view.camera(&scene.bounds).expect("a camera");
        let expected = renderer.staged(&camera, &options).map(|_| ()).expect_err("an error");
        let found = renderer.staged_on(&mut Device::default(), &camera, &options).map(|_| ()).expect_err("an error");
        // Which patch comes first is up to the CPU's threads.
        assert_eq!(discriminant(&found), discriminant(&expected), "{found}, not {expected}");
        println!("{found}");
    };
    let options = Options::default();
    stopped("builtin:teapot", view(false, 1.0), Options { tolerance: 0.00196, ..options });
    stopped("builtin:torus", view(false, 1.0), Options { depth_tolerance: 1e-30, ..options });
    stopped("builtin:sphere", view(false, 1e25), options);
}

/// Whatever order blocks, warps and lanes take: halvings of all kinds, trims and rational nets.
#[test]
fn any_order_gives_the_same_words() {
    let fine = Options { tolerance: 0.02, depth_tolerance: 0.05, ..Options::default() };
    let mut met = Met::default();
    for (name, zoom) in [("builtin:torus", 9.0), ("builtin:trimmed:wedge", 3.0)] {
        let scene = scene(name);
        let renderer = Renderer::new(&scene);
        let (center, radius) = (scene.bounds.center(), scene.bounds.radius());
        let inside = Some(center + DVec3::new(0.3, -0.2, 0.25) * radius);
        let closer = ViewSpec { size: [320, 240], ..view(false, zoom) };
        let within = ViewSpec { eye: inside, target: Some(center), ..view(false, 1.0) };
        for (view, options) in [(closer, fine), (within, Options::default())] {
            let camera = view.camera(&scene.bounds).expect("a camera");
            let (expected, _) = renderer.staged(&camera, &options).expect("a frame");
            met.add(&expected);
            under_all_schedules(|device| {
                let (found, _) = renderer.staged_on(device, &camera, &options).expect("a frame");
                compare(&found, &expected, &format!("{name}, {:?}", device.schedule));
            });
        }
    }
    assert!(met.rational_parts > 50 && met.deep > 0 && met.tested > 40, "{met:?}");
}

/// Patches get the same arithmetic, and halves where it needs them. The list of meshlets follows from vertices as they are
/// drawn, so that it is the CPU's only where nothing is trimmed.
#[test]
fn every_precision_is_chosen_alike() {
    let mut chosen = BTreeMap::new();
    for name in MODELS {
        let scene = scene(name);
        let renderer = Renderer::new(&scene);
        for &precision in Precision::value_variants() {
            for (frame, orthographic, zoom) in [(FrameShape::Staged, false, 1.0), (FrameShape::Fused, true, 6.0)] {
                let camera = view(orthographic, zoom).camera(&scene.bounds).expect("a camera");
                let bound = if orthographic { Bound::Screen } else { Bound::Eter };
                let trim = if orthographic { Trim::Off } else { Trim::On };
                let options = Options { precision, frame, bound, trim, ..Options::default() };
                let (mut expected, _) = renderer.staged(&camera, &options).expect("a frame");
                let (mut found, _) = renderer.staged_on(&mut Device::default(), &camera, &options).expect("a frame");
                for k in 0..found.patches.len() {
                    *chosen.entry((precision, found.arithmetic(k))).or_insert(0) += 1;
                }
                if trim == Trim::On && precision != Precision::F32 {
                    for staged in [&mut expected, &mut found] {
                        staged.meshlets.clear();
                        staged.vertices = 0;
                    }
                }
                compare(&found, &expected, &format!("{name} {precision:?} {frame:?}"));
            }
        }
    }
    let met = |p, a| chosen.get(&(p, a)).copied().unwrap_or(0);
    assert!(met(Precision::Auto, Arithmetic::F32) > 100 && met(Precision::Auto, Arithmetic::Tf32) > 30, "{chosen:?}");
    assert!(
        met(Precision::Auto, Arithmetic::F16Recovered) > 5 && met(Precision::F16, Arithmetic::F16) > 200,
        "{chosen:?}"
    );
}

/// What is told of a frame.
#[test]
fn counts_are_the_cpus() {
    for name in MODELS {
        let scene = scene(name);
        let mut renderer = Renderer::new(&scene);
        for zoom in [1.0, 7.0] {
            let camera = ViewSpec { size: [320, 200], ..view(false, zoom) }.camera(&scene.bounds).expect("a camera");
            let options = Options { tolerance: 0.2, ..Options::default() };
            let (_, found) = renderer.staged_on(&mut Device::default(), &camera, &options).expect("a frame");
            let stats = renderer.render(&camera, &options).expect("a frame").stats;
            let expected = GeometryCounts {
                patches_visible: stats.patches_visible,
                quads: stats.quads,
                meshlets_outside: stats.trim.meshlets_outside,
                meshlets_inside: stats.trim.meshlets_inside,
                meshlets_boundary: stats.trim.meshlets_boundary,
            };
            assert_eq!(found, expected, "{name}");
        }
    }
}

/// Eyes within the model: the near plane cuts patches open.
#[test]
fn near_planes_split_alike() {
    let mut met = Met::default();
    for name in MODELS {
        let scene = scene(name);
        let (center, radius) = (scene.bounds.center(), scene.bounds.radius());
        for (k, orthographic) in [(1.0, false), (-0.6, false), (0.3, true)] {
            let eye = Some(center + DVec3::new(0.3, -0.2 * k, 0.25) * radius);
            let target = Some(center + DVec3::new(-k, 0.8, 0.1) * radius);
            let view = ViewSpec { eye, target, ..view(orthographic, 1.0) };
            met.add(&check(&scene, view, Options::default(), name));
        }
    }
    assert!(met.rational_parts > 1000 && met.deep > 1000 && met.untested_of_trimmed > 100, "{met:?}");
}

#[test]
fn every_bound_and_grid_is_the_cpus() {
    for name in MODELS {
        let scene = scene(name);
        for bound in Bound::ALL {
            for (grid, cull) in [(Grid::Variable, Cull::Off), (Grid::Eter, Cull::On), (Grid::Eter16, Cull::Auto)] {
                let polynomial = scene.patches.iter().all(|p| !p.rational && p.degree[0].max(p.degree[1]) <= 7);
                if bound == Bound::Slefe && !polynomial {
                    continue;
                }
                let options = Options { bound, grid, cull, ..Options::default() };
                check(&scene, view(grid == Grid::Eter, 1.5), options, name);
            }
        }
    }
}
