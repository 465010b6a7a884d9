//! Thousands of small solids on one heap: outlines, fillets and seams of less than a pixel, in front of each other.

use super::random::Random;
use glam::{DAffine3, DQuat, DVec3};
use halfpixel::import::load;
use halfpixel::model::{Instance, Layout, Model};
use halfpixel::scene::{View, ViewSpec, prepare};
use halfpixel::stages::{Options, Renderer};
use halfpixel::verify::{Report, Sampling, verify};
use std::f64::consts::TAU;

/// Solids with round outlines, a void, sweeps and several instances.
const SOLIDS: [&str; 8] = [
    "cylinder_two_loops",
    "cylinder_seam",
    "torus_seams",
    "void",
    "mapped_items",
    "sphere_whole",
    "swept_profiles",
    "cone_sections",
];
/// Edge length of the square that the heap covers; about a third of a pixel's in the picture.
const WIDTH: f64 = 100.0;

/// `count` solids of about the given size, anywhere and any way round.
fn heap(count: usize, size: f64, seed: u64) -> Model {
    let files = SOLIDS.map(|name| load(&format!("tests/models/{name}.step")).expect(name));
    let mut all = Model::join(files.into(), Layout::Overlay);
    let mut random = Random(seed);
    let boxes: Vec<Option<[DVec3; 2]>> = (all.instances.iter())
        .map(|instance| {
            let parts = vec![all.parts[instance.part].clone()];
            Model { parts, instances: vec![Instance { part: 0, ..instance.clone() }], ..Model::default() }.bounds()
        })
        .collect();
    let place = |_| {
        let k = random.below(boxes.len());
        let [low, high] = boxes[k]?;
        let to = random.point(0.5 * WIDTH) * DVec3::new(1.0, 1.0, 0.2);
        let turn = DQuat::from_axis_angle(random.point(1.0).normalize(), random.between(0.0, TAU));
        let scale = size * random.between(0.3, 1.3) / (high - low).length();
        let moved = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turn, to);
        let transform = moved * DAffine3::from_translation(-0.5 * (low + high)) * all.instances[k].transform;
        Some(Instance { transform, ..all.instances[k].clone() })
    };
    all.instances = (0..count).filter_map(place).collect();
    all
}

/// The oracle on every pixel.
pub fn judged(count: usize, size: f64, seed: u64, view: View, orthographic: bool) -> Report {
    let scene = prepare(&heap(count, size, seed), &|_, _| {}).expect("a scene");
    let spec = ViewSpec { size: [320, 240], view, orthographic, ..ViewSpec::default() };
    let camera = spec.camera(&scene.bounds).expect("a camera");
    let frame = Renderer::new(&scene).render(&camera, &Options::default()).expect("a frame");
    verify(&scene, &camera, &Options::default(), &|x, y| frame.pixel(x, y), &Sampling::default(), &|_, _| {})
}
