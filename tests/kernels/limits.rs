//! Frames that can't be had end with the CPU's own words.

use halfpixel::emulated::Device;
use halfpixel::import;
use halfpixel::scene::{Scene, ViewSpec, prepare};
use halfpixel::stages::{Grid, Options, RenderError, Renderer};

fn scene(name: &str) -> Scene {
    prepare(&import::load(name).expect("a model"), &|_, _| {}).expect("a scene")
}

/// One patch of a model alone: which of several fails first is up to the CPU's threads.
fn one_patch(name: &str, patch: usize) -> Scene {
    let mut scene = scene(name);
    scene.instances.truncate(1);
    scene.instances[0].patches = patch..patch + 1;
    scene
}

fn view() -> ViewSpec {
    ViewSpec { size: [640, 480], ..ViewSpec::default() }
}

/// What stops the CPU, and in the same words a device.
fn stopped(scene: &Scene, zoom: f64, options: Options) -> RenderError {
    let renderer = Renderer::new(scene);
    let camera = ViewSpec { zoom, ..view() }.camera(&scene.bounds).expect("a camera");
    let expected = renderer.staged(&camera, &options).map(|_| ()).expect_err("an error of the CPU");
    let found = renderer.staged_on(&mut Device::default(), &camera, &options).map(|_| ()).expect_err("an error");
    assert_eq!(found, expected);
    assert_eq!(found.to_string(), expected.to_string());
    println!("{found}");
    found
}

#[test]
fn tolerances_below_rounding() {
    let options = Options { tolerance: 0.00196, ..Options::default() };
    let found = stopped(&one_patch("builtin:teapot", 0), 1.0, options);
    assert!(matches!(found, RenderError::ToleranceTooSmall { .. }), "{found}");
}

#[test]
fn grids_that_stay_too_large() {
    let options = Options { depth_tolerance: 1e-30, ..Options::default() };
    let found = stopped(&one_patch("builtin:torus", 0), 1.0, options);
    assert!(matches!(found, RenderError::GridTooLarge { .. }), "{found}");
}

#[test]
fn patches_too_close_to_be_split() {
    let zoom = 1e25;
    let shown = (0..scene("builtin:sphere").patches.len()).map(|k| one_patch("builtin:sphere", k)).find(|scene| {
        let camera = ViewSpec { zoom, ..view() }.camera(&scene.bounds).expect("a camera");
        Renderer::new(scene).staged(&camera, &Options::default()).is_err()
    });
    let found = stopped(&shown.expect("some patch is in the image's middle"), zoom, Options::default());
    assert!(matches!(found, RenderError::TooClose { .. }), "{found}");
}

/// Thousands of instances of a patch, each with nearly the largest grid there is: no memory is taken for them.
#[test]
fn more_vertices_than_a_frame_holds() {
    let mut scene = one_patch("builtin:torus", 0);
    let camera = view().camera(&scene.bounds).expect("a camera");
    let tolerances = (0..40).map(|k| 1e-4 * 1.2_f64.powi(k));
    let options =
        tolerances.map(|depth_tolerance| Options { depth_tolerance, grid: Grid::Variable, ..Options::default() });
    let found = options.map(|options| (options, Renderer::new(&scene).staged(&camera, &options).expect("a patch").0));
    let (options, one) = found.into_iter().find(|(_, staged)| staged.leaves.len() == 1).expect("a whole patch");
    scene.instances = vec![scene.instances[0].clone(); (1 << 28) / one.vertices + 1];
    let found = stopped(&scene, 1.0, options);
    assert!(matches!(found, RenderError::TooManyVertices { .. }), "{found}");
}
