//! From a patch's own coordinates to pixel-homogeneous ones, in f64.

use super::evaluate::SUBPIXELS;
use crate::scene::{Camera, Projection, SceneInstance};
use glam::{DAffine3, DMat3, DVec3, DVec4};

/// A camera as the stages use it.
///
/// A homogeneous point `(wx, wy, wz, w)` becomes `(X, Y, Z, w)`: `Z = w z` with z the camera depth, and the pixel is
/// `(X, Y) / D` about the image centre, where the denominator D is Z in perspective and w in orthographic views.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lens {
    pub size: [u32; 2],
    pub perspective: bool,
    /// Pixels a unit: focal length in perspective, scale in orthographic views.
    pub scale: f64,
    pub near: f64,
    pub extent: f64,
    pub eye: DVec3,
    /// Rows: right, down, forward.
    pub axes: [DVec3; 3],
}

/// The map of one patch: rows give X, Y, Z of a local homogeneous point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchMap {
    pub rows: [DVec4; 3],
    /// Camera axes in the patch's own coordinates (right, down, forward), instance scale included.
    pub axes: [DVec3; 3],
}

impl Lens {
    pub fn new(camera: &Camera) -> Self {
        let (perspective, scale) = match camera.projection {
            Projection::Perspective { focal } => (true, focal),
            Projection::Orthographic { scale } => (false, scale),
        };
        Self {
            size: camera.size,
            perspective,
            scale,
            near: camera.near,
            extent: camera.extent,
            eye: camera.eye,
            axes: [camera.right, camera.down, camera.forward],
        }
    }

    /// The map of a patch about `origin` in an instance.
    pub fn patch_map(&self, instance: &SceneInstance, origin: DVec3) -> PatchMap {
        let axes = self.object_axes(&instance.transform);
        // The origins meet before anything is scaled: models far from (0, 0, 0) lose nothing.
        let offset = instance.transform.transform_point3(origin) - self.eye;
        let rows = std::array::from_fn(|k| {
            let factor = if k < 2 { self.scale } else { 1.0 };
            (axes[k] * factor).extend(self.axes[k].dot(offset) * factor)
        });
        PatchMap { rows, axes }
    }

    /// `q . S` in camera space equals `object_axes(q) . S` in the instance's own coordinates.
    fn object_axes(&self, transform: &DAffine3) -> [DVec3; 3] {
        let linear: DMat3 = transform.matrix3;
        self.axes.map(|axis| linear.transpose() * axis)
    }

    /// The near plane takes nothing that the image would show of a ball: all of it is deeper, or so far away that what
    /// is nearer lies outside the image.
    pub fn shows_whole(&self, center: DVec3, radius: f64) -> bool {
        let towards = center - self.eye;
        let corner = DVec3::new(self.half(0) / self.scale, self.half(1) / self.scale, 1.0).length();
        let beyond_corner = self.perspective && towards.length() - radius >= self.near * corner;
        self.axes[2].dot(towards) - radius >= self.near || beyond_corner
    }

    /// Half the image in pixels: the image is [-half, half] about its centre.
    pub fn half(&self, axis: usize) -> f64 {
        f64::from(self.size[axis]) * 0.5
    }

    /// The denominator of the projection.
    pub fn denominator(&self, p: DVec4) -> f64 {
        if self.perspective { p.z } else { p.w }
    }

    /// Sub-pixel position, from the image's top left corner, of a pixel about the image's centre. That centre is a whole or
    /// half pixel: exact.
    pub fn base(&self, center: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|k| center[k] * SUBPIXELS + self.size[k] as i32 * (SUBPIXELS / 2))
    }

    /// The stored depth at a camera depth in orthographic views.
    pub fn depth_offset(&self, z: f64) -> f32 {
        (1.0 - (z - self.near) / self.extent) as f32
    }

    /// Stored depth lost a unit of camera depth in orthographic views.
    pub fn depth_slope(&self) -> f32 {
        (1.0 / self.extent) as f32
    }

    /// Size of a pixel in model units at camera depth z.
    pub fn pixel_size(&self, z: f64) -> f64 {
        if self.perspective { z / self.scale } else { 1.0 / self.scale }
    }
}

impl PatchMap {
    pub fn apply(&self, p: DVec4) -> DVec4 {
        DVec4::new(self.rows[0].dot(p), self.rows[1].dot(p), self.rows[2].dot(p), p.w)
    }
}
