//! What a pixel shows besides its colour, evaluated in f64 on the exact surface.

use crate::geometry::SurfacePoint;
use crate::scene::{Camera, Projection, Scene, SceneInstance};
use crate::stages::{Frame, Pixel};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Number of the face, patch and instance where nothing is shown.
pub const NO_ID: u32 = u32::MAX;

/// The channels of one pixel. Every number is finite; background is 0 everywhere, with ids of `NO_ID`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attributes {
    /// Linear.
    pub rgba: [f32; 4],
    /// Camera depth: distance along the view direction, model units.
    pub depth: f32,
    /// Unit normal in the world, `S_u x S_v`, outward where the surface bounds a solid.
    pub normal: [f32; 3],
    /// In the world, model units.
    pub position: [f32; 3],
    /// In the source surface's own parameters.
    pub uv: [f32; 2],
    /// Face (the file's own number where it has one), patch and instance.
    pub id: [u32; 3],
}

/// The attributes of all pixels, row by row from the top.
pub fn attributes(scene: &Scene, frame: &Frame) -> Vec<Attributes> {
    let [width, height] = frame.camera.size;
    (0..width * height).into_par_iter().map(|i| pixel_attributes(scene, frame, i % width, i / width)).collect()
}

fn pixel_attributes(scene: &Scene, frame: &Frame, x: u32, y: u32) -> Attributes {
    let rgba = frame.color(x, y).map(|c| finite(f64::from(c)));
    let Some(pixel) = frame.pixel(x, y) else {
        return Attributes { rgba, depth: 0.0, normal: [0.0; 3], position: [0.0; 3], uv: [0.0; 2], id: [NO_ID; 3] };
    };
    let patch = &scene.patches[pixel.patch as usize];
    let instance = &scene.instances[pixel.instance as usize];
    let [u, v] = pixel.stored;
    let point = scene.net(patch).surface_point(u, v);
    let position = instance.transform.transform_point3(patch.origin + point.position);
    let normal = normal(scene, instance, &pixel, &point).unwrap_or_else(|| towards_eye(&frame.camera, position));
    let parameter = |axis: usize, t: f64| {
        let [low, high] = patch.domain[axis];
        finite(low * (1.0 - t) + high * t)
    };
    Attributes {
        rgba,
        depth: finite(frame.camera.to_camera(position).z),
        normal: normal.to_array().map(finite),
        position: position.to_array().map(finite),
        uv: [parameter(0, u), parameter(1, v)],
        id: [scene.faces[patch.face as usize].id, pixel.patch, pixel.instance],
    }
}

/// Unit normal in the world; `None` where the surface has none.
fn normal(scene: &Scene, instance: &SceneInstance, pixel: &Pixel, point: &SurfacePoint) -> Option<DVec3> {
    let map: DMat3 = instance.transform.matrix3;
    // A mirrored part keeps its outside outside.
    let side = map.determinant().signum();
    let of = |p: &SurfacePoint| {
        let normal = (map * p.du.normalize_or_zero()).cross(map * p.dv.normalize_or_zero());
        (normal.length() > 1e-12 * map.determinant().abs().cbrt().powi(2)).then(|| normal.normalize() * side)
    };
    of(point).or_else(|| {
        // At a pole the derivatives say nothing; a little towards the middle of the patch they do.
        let [u, v] = pixel.stored.map(|t| t + (0.5 - t) * 1e-5);
        of(&scene.net(&scene.patches[pixel.patch as usize]).surface_point(u, v))
    })
}

/// Unit vector from a point to the eye; against the view direction where every ray has that.
fn towards_eye(camera: &Camera, point: DVec3) -> DVec3 {
    match camera.projection {
        Projection::Perspective { .. } => (camera.eye - point).try_normalize().unwrap_or(-camera.forward),
        Projection::Orthographic { .. } => -camera.forward,
    }
}

/// The nearest finite f32; 0 for what is not a number.
fn finite(x: f64) -> f32 {
    if x.is_nan() { 0.0 } else { (x as f32).clamp(f32::MIN, f32::MAX) }
}
