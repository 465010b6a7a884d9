//! Patches as one camera sees them: homogeneous pixel coordinates in f64.
//!
//! A view point is `(X, Y, Z, W)` with `W` the rational weight, `Z / W` the camera depth, and pixels,
//! relative to the image centre, `X / D` and `Y / D`. The divisor `D` is `Z` in perspective and `W` in orthographic
//! projection. All four are linear in the homogeneous control points, so Bézier nets stay Bézier nets and their convex
//! hulls stay valid, in front of the eye and behind it.

use crate::geometry::{Jet, Net};
use crate::scene::{Camera, Patch, Projection, Scene, SceneInstance};
use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};

/// What the oracle needs of a camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    camera: Camera,
    /// World directions to (X, Y, Z).
    rows: DMat3,
    perspective: bool,
}

/// One patch of one instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub instance: u32,
    pub patch: u32,
    /// The patch's local coordinates to (X, Y, Z).
    to_view: DAffine3,
    /// What (F, G) of its points may be off by, from rounding.
    pub noise: f64,
}

/// A surface point in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImagePoint {
    /// Pixels from the image's top left corner.
    pub pixel: DVec2,
    /// Camera depth.
    pub depth: f64,
}

impl View {
    pub fn new(camera: &Camera) -> Self {
        let (magnify, perspective) = match camera.projection {
            Projection::Perspective { focal } => (focal, true),
            Projection::Orthographic { scale } => (scale, false),
        };
        let rows = DMat3::from_cols(camera.right * magnify, camera.down * magnify, camera.forward).transpose();
        Self { camera: *camera, rows, perspective }
    }

    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The patch's way into the image. Its origin, the instance's place and the eye may be huge and cancel, so that sum
    /// is compensated; what is left is relative to the eye.
    pub fn drawn(&self, scene: &Scene, instance: u32, patch: u32) -> Drawn {
        let SceneInstance { transform, .. } = &scene.instances[instance as usize];
        let origin = scene.patches[patch as usize].origin;
        let rows = transform.matrix3.transpose();
        let from_eye = DVec3::from_array(std::array::from_fn(|axis| {
            let row = rows.col(axis);
            compensated_dot(
                [row.x, row.y, row.z, 1.0, -1.0],
                [origin.x, origin.y, origin.z, transform.translation[axis], self.camera.eye[axis]],
            )
        }));
        let to_view = DAffine3 { matrix3: self.rows * transform.matrix3, translation: self.rows * from_eye };
        Drawn { instance, patch, to_view, noise: 0.0 }
    }

    /// D, what pixels are divided by.
    pub fn divisor(&self, q: DVec4) -> f64 {
        if self.perspective { q.z } else { q.w }
    }

    /// At least 0 where the point is not nearer than the near distance; linear.
    pub fn clearance(&self, q: DVec4) -> f64 {
        q.z - self.camera.near * q.w
    }

    /// Camera depth of a point that is not nearer than near (by rounding neither).
    pub fn depth(&self, q: DVec4) -> f64 {
        (q.z / q.w).max(self.camera.near)
    }

    /// What rounding can do to (F, G) of points of this view net, for rays in the image: a few dozen operations on
    /// numbers no larger than these. It matters only for patches that are some 1e9 times larger than a pixel.
    pub fn noise(&self, net: Net<'_>) -> f64 {
        let reach = self.camera.center().max_element();
        let size = |q: &DVec4| q.x.abs().max(q.y.abs()) + reach * self.divisor(*q).abs();
        64.0 * f64::EPSILON * net.points().iter().map(size).fold(0.0, f64::max)
    }

    /// Pixels relative to the image centre.
    pub fn pixel(&self, q: DVec4) -> DVec2 {
        q.truncate().truncate() / self.divisor(q)
    }

    /// D of a point moved to the near plane where it is nearer.
    pub fn divisor_no_nearer(&self, q: DVec4) -> f64 {
        self.divisor(DVec4 { z: q.z.max(self.camera.near * q.w), ..q })
    }

    /// The pixel of such a point: a measure of lengths also about the eye.
    pub fn pixel_no_nearer(&self, q: DVec4) -> DVec2 {
        q.truncate().truncate() / self.divisor_no_nearer(q)
    }

    /// `(F, G)`: zero where the point lies on the ray through pixel `p` (relative to the image centre); linear.
    pub fn off_ray(&self, q: DVec4, p: DVec2) -> DVec2 {
        q.truncate().truncate() - p * self.divisor(q)
    }

    pub fn image_point(&self, q: DVec4) -> ImagePoint {
        ImagePoint { pixel: self.pixel(q) + self.camera.center(), depth: q.z / q.w }
    }
}

impl Drawn {
    pub fn to_view(self, q: DVec4) -> DVec4 {
        let p = self.to_view.matrix3 * q.truncate() + self.to_view.translation * q.w;
        p.extend(q.w)
    }

    pub fn source<'a>(&self, scene: &'a Scene) -> &'a Patch {
        &scene.patches[self.patch as usize]
    }

    pub fn net<'a>(&self, scene: &'a Scene) -> Net<'a> {
        scene.net(self.source(scene))
    }

    /// View point and its derivatives at (u, v).
    pub fn jet(&self, scene: &Scene, u: f64, v: f64) -> Jet {
        let jet = self.net(scene).jet(u, v);
        Jet { point: self.to_view(jet.point), du: self.to_view(jet.du), dv: self.to_view(jet.dv) }
    }
}

/// `sum a_i b_i` as if summed in twice the precision (Ogita, Rump, Oishi. Accurate sum and dot product. 2005, Dot2).
fn compensated_dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    let (mut sum, mut error) = (0.0_f64, 0.0_f64);
    for (x, y) in a.into_iter().zip(b) {
        let product = x * y;
        let product_error = x.mul_add(y, -product);
        let next = sum + product;
        let part = next - sum;
        let sum_error = (sum - (next - part)) + (product - part);
        error += product_error + sum_error;
        sum = next;
    }
    sum + error
}

#[cfg(test)]
mod tests {
    use super::compensated_dot;

    #[test]
    fn huge_terms_cancel_exactly() {
        assert_eq!(compensated_dot([1e9, 1e9, 1.0, 1.0], [1e9, -1e9, 0.1, 0.0]), 0.1);
        assert_eq!(compensated_dot([1.0, 1.0, -1.0], [1e17, 3.0, 1e17]), 3.0);
    }
}
