//! cull, estimate and the list of meshlets by kernels against the CPU's, word for word.

use halfpixel::cuda::evaluate::Staged;
use halfpixel::emulated::{Device, Schedule};
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Bound, Cull, Grid, Options, Renderer};

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

const MODELS: [&str; 5] =
    ["builtin:teapot", "builtin:torus", "builtin:drum", "builtin:trimmed:drilled", "builtin:stress"];

fn view(orthographic: bool, zoom: f64) -> ViewSpec {
    ViewSpec { size: [160, 120], zoom, orthographic, ..ViewSpec::default() }
}

#[test]
fn geometry_is_the_cpus() {
    for name in MODELS {
        let scene = scene(name);
        for (orthographic, zoom) in [(false, 1.0), (true, 1.0), (false, 6.0)] {
            check(&scene, view(orthographic, zoom), Options::default(), name);
        }
    }
}

#[test]
fn every_bound_and_grid_is_the_cpus() {
    for name in MODELS {
        let scene = scene(name);
        for bound in Bound::ALL {
            for (grid, cull) in [(Grid::Variable, Cull::Off), (Grid::Eter, Cull::On)] {
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
