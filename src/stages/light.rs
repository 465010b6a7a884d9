//! Part of shade: the light on eight pixels at a time.

use super::lens::Lens;
use super::newton::{Batch, LANES};
use fearless_simd::{f32x8, prelude::*};
use fearless_simd_macros::simd;

/// Directional lights in camera axes (x right, y down, z away): unit direction towards the light and strength.
const LIGHTS: [([f32; 3], f32); 2] =
    [([-0.450_653_94, -0.650_944_53, -0.610_886_4], 0.85), ([0.751_882, 0.100_250_94, -0.651_631_1], 0.30)];
const AMBIENT: f32 = 0.08;
const SPECULAR: f32 = 0.25;
/// The shine is to the power of two to this.
const SQUARINGS: usize = 5;

/// Where eight pixels are seen.
pub(super) struct Seen<'a> {
    pub lens: &'a Lens,
    /// Centre of the leaf, in pixels about the image's.
    pub center: [i32; 2],
    /// Places of the pixels in the image.
    pub pixels: [[u32; 2]; LANES],
}

/// What eight pixels get.
#[derive(Default)]
pub(super) struct Light {
    /// Camera axes, facing the eye, unit length; towards the eye where the surface has none.
    pub normal: [[f32; LANES]; 3],
    /// Times the surface's colour.
    pub diffuse: [f32; LANES],
    /// Of the lights' own colour, white.
    pub specular: [f32; LANES],
}

impl Light {
    /// Linear RGB of a pixel with this colour (Blinn-Phong).
    pub fn on(&self, base: [f32; 3], lane: usize) -> [f32; 3] {
        base.map(|c| c * self.diffuse[lane] + self.specular[lane])
    }
}

/// The batch's normals in camera axes, and what its pixels get.
///
/// A leaf's affine axes are M times camera axes, M = [[f, 0, -cx], [0, f, -cy], [0, 0, 1]] in perspective and
/// diag(s, s, 1) in orthographic views: normals go back with the transpose of M.
#[simd]
pub(super) fn light<S: Simd>(simd: S, seen: &Seen, batch: &Batch, light: &mut Light) {
    let lens = seen.lens;
    let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
    // Only the direction counts: M over its scale keeps numbers near one.
    let inverse = f32x8::splat(simd, 1.0 / lens.scale as f32);
    let mut ray = [zero, zero, one];
    if lens.perspective {
        for k in 0..2 {
            let half = f32x8::splat(simd, lens.half(k) as f32);
            let center = f32x8::from_slice(simd, &seen.pixels.map(|pixel| pixel[k] as f32 + 0.5));
            ray[k] = (center - half) * inverse;
        }
        ray = unit(simd, ray, [zero, zero, one]);
    }
    let towards_eye = [-ray[0], -ray[1], -ray[2]];
    // No closures here: what calls them lacks the SIMD level, and each operation in them becomes a call.
    let [x, y, z] = &batch.normal;
    let [x, y, z] = [f32x8::from_slice(simd, x), f32x8::from_slice(simd, y), f32x8::from_slice(simd, z)];
    let [x, y, z] = unit(simd, [x, y, z], [zero; 3]);
    let mut z = z * inverse;
    if lens.perspective {
        z -= (x * seen.center[0] as f32 + y * seen.center[1] as f32) * inverse;
    }
    let normal = unit(simd, [x, y, z], towards_eye);
    let away = dot(simd, normal, ray).simd_gt(zero);
    let [x, y, z] = normal;
    let normal = [away.select(-x, x), away.select(-y, y), away.select(-z, z)];
    let (mut diffuse, mut specular) = (f32x8::splat(simd, AMBIENT), zero);
    for (towards, strength) in LIGHTS {
        let [x, y, z] = towards;
        let towards = [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)];
        diffuse += dot(simd, normal, towards).max(zero) * strength;
        let half = [towards[0] + towards_eye[0], towards[1] + towards_eye[1], towards[2] + towards_eye[2]];
        let mut shine = dot(simd, normal, unit(simd, half, [zero; 3])).max(zero);
        for _ in 0..SQUARINGS {
            shine *= shine;
        }
        specular += shine * (strength * SPECULAR);
    }
    for (normal, out) in normal.into_iter().zip(&mut light.normal) {
        normal.store_slice(out);
    }
    diffuse.store_slice(&mut light.diffuse);
    specular.store_slice(&mut light.specular);
}

#[simd]
fn dot<S: Simd>(_: S, a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> f32x8<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A direction of unit length, or the other where there is none.
#[simd]
fn unit<S: Simd>(simd: S, v: [f32x8<S>; 3], other: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    let zero = f32x8::splat(simd, 0.0);
    let by = f32x8::splat(simd, 1.0) / dot(simd, v, v).sqrt();
    // Neither of zero length nor beyond what f32 holds.
    let known = by.simd_gt(zero) & by.simd_lt(f32x8::splat(simd, f32::INFINITY));
    [known.select(v[0] * by, other[0]), known.select(v[1] * by, other[1]), known.select(v[2] * by, other[2])]
}
