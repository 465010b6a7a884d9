//! Scenes, cameras and random patches.

#[path = "../support/random.rs"]
mod random;

use glam::{DVec2, DVec3};
use halfpixel::geometry::BezierPatch;
use halfpixel::import::builtin::builtin;
use halfpixel::model::{Face, Model, Part, Solidity, Surface};
use halfpixel::scene::{Camera, Scene, ViewSpec, prepare};
use halfpixel::stages::{Frame, Options, Pixel, Renderer};
pub use random::Random;

pub fn scene(name: &str) -> Scene {
    prepare(&builtin(name).expect(name), &|_, _| {}).expect(name)
}

/// A scene of one open patch.
pub fn single(patch: BezierPatch) -> Scene {
    let face = Face::new(0, "", Surface::single(patch));
    let part = Part { faces: vec![face], solidity: Solidity::Open, ..Part::default() };
    prepare(&Model::from_part("patch", part), &|_, _| {}).expect("a scene")
}

pub fn camera(scene: &Scene, spec: ViewSpec) -> Camera {
    spec.camera(&scene.bounds).expect("a camera")
}

pub fn render(scene: &Scene, camera: &Camera, options: &Options) -> Frame {
    Renderer::new(scene).render(camera, options).expect("a frame")
}

pub fn pixels(size: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y]))
}

/// The surface point of a pixel's patch at (u, v), in camera coordinates; f64 throughout.
pub fn in_camera(scene: &Scene, camera: &Camera, pixel: &Pixel, [u, v]: [f64; 2]) -> DVec3 {
    let patch = &scene.patches[pixel.patch as usize];
    let local = scene.net(patch).surface_point(u, v).position + patch.origin;
    camera.to_camera(scene.instances[pixel.instance as usize].transform.transform_point3(local))
}

/// L-infinity distance in pixels from the centre of pixel (x, y) to what it shows at (u, v).
pub fn error(scene: &Scene, camera: &Camera, [x, y]: [u32; 2], pixel: &Pixel, uv: [f64; 2]) -> f64 {
    let shown = camera.project(in_camera(scene, camera, pixel, uv));
    (shown - DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).abs().max_element()
}

/// The 25 sub-samples of a pixel, from border to border.
pub fn subsamples([x, y]: [u32; 2]) -> impl Iterator<Item = DVec2> {
    let at = |p: u32, k: usize| f64::from(p) + k as f64 / 4.0;
    (0..25).map(move |k| DVec2::new(at(x, k % 5), at(y, k / 5)))
}

/// The ray through an image point in the world: `origin + z step` has camera depth z.
pub fn ray(camera: &Camera, at: DVec2) -> (DVec3, DVec3) {
    let world = |c: DVec3| camera.right * c.x + camera.down * c.y + camera.forward * c.z;
    let (origin, step) = camera.ray(at.x, at.y);
    (camera.eye + world(origin), world(step))
}
