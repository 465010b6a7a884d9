//! Part of cull: whether all of a patch faces away, from cones of its normals and of the directions it is seen in. Twin:
//! kernels/cone.cuh; cosines alone are compared, since devices have arc functions of their own.

use super::lens::PatchMap;
use glam::DVec3;

/// What rounding may have added to a cosine of unit vectors.
const ROUNDING: f64 = 1e-15;
/// By how much a cosine must be larger than the sine it is compared with, rounding included.
const CLEARLY: f64 = 1e-9;

/// A cone of directions: a unit axis and the cosine of the half angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    pub axis: DVec3,
    pub cos: f64,
}

impl Cone {
    /// Less than a right angle lies between any two directions of the cones: all surfaces with normals in one that are seen
    /// along the other face away.
    pub fn is_near(&self, other: &Cone) -> bool {
        // The half angles' sum, by the addition theorems; together with the angle between the axes it must be less than 90°.
        let [(cos_a, sin_a), (cos_b, sin_b)] = [self, other].map(|cone| {
            let cos = cone.cos - ROUNDING;
            (cos, (1.0 - cos * cos).max(0.0).sqrt())
        });
        let cos = cos_a * cos_b - sin_a * sin_b;
        let sin = sin_a * cos_b + cos_a * sin_b;
        cos_a > 0.0 && cos_b > 0.0 && cos > 0.0 && self.axis.dot(other.axis) > sin + CLEARLY
    }

    /// The directions from the eye to a ball about a patch's origin, in the patch's own coordinates; `None`: the eye is in it.
    pub fn of_rays(radius: f64, map: &PatchMap) -> Option<Cone> {
        let eye = eye(map);
        let distance = eye.length();
        let sin = radius / distance;
        (sin < 1.0).then(|| Cone { axis: eye * (-1.0 / distance), cos: (1.0 - sin * sin).sqrt() })
    }

    /// The one direction that leaves a pixel where it is, of an orthographic view; the forward axis itself only where nothing
    /// is stretched.
    pub fn of_parallel_rays(map: &PatchMap) -> Cone {
        let [x, y, z] = map.axes;
        let along = x.cross(y);
        Cone { axis: (along * along.dot(z).signum()).normalize(), cos: 1.0 }
    }
}

/// The eye in local coordinates, where all rows are zero, by Cramer's rule.
fn eye(map: &PatchMap) -> DVec3 {
    let [a, b, c] = map.rows.map(|row| row.truncate());
    let (bc, ca, ab) = (b.cross(c), c.cross(a), a.cross(b));
    let [x, y, z] = map.rows.map(|row| row.w);
    (bc * x + ca * y + ab * z) * (-1.0 / a.dot(bc))
}
