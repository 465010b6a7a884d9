//! Part of refinement: Newton's method beside a fold of the surface's image.
//!
//! There the map from parameters to pixels is nearly singular: it sees a step along one direction `v` of the parameter
//! plane well and one across it hardly at all. A plain step overshoots without bound along the unseen direction; halving
//! it shrinks the seen part too and gets nowhere. So the seen part is taken whole, the unseen one by a fraction, and what
//! trials miss tells the curvature of the surface's image: the next one goes along a parabola in the parameter plane and
//! solves a quadratic equation for the fraction.

use super::newton::Surface;
use fearless_simd::{f32x8, mask32x8, prelude::*};
use fearless_simd_macros::simd;

/// Squared ratio of the singular values below which the map counts as nearly singular.
pub(super) const NEAR_FOLD: f32 = 1.0 / 16.0;
/// Leaf parameters that a parabola is trusted for.
const FAR: f32 = 0.25;
const TINY: f32 = 1e-30;
/// Derivatives are off by the degree times what a point is off by; times four, to be sure.
const DERIVATIVE_ROUNDING: f32 = 4.0;

/// `seen + unseen f + bend f²` for fractions f of the unseen part.
///
/// On the fold itself the unseen part's length is rounding: there its direction alone is used, as far as a parabola goes.
pub(super) struct FoldStep<S: Simd> {
    seen: [f32x8<S>; 2],
    unseen: [f32x8<S>; 2],
    bend: [f32x8<S>; 2],
    fraction: f32x8<S>,
    /// The largest fraction, and what of `across` the whole unseen part should remove: one, and one; on the fold nothing
    /// is known of either.
    limit: f32x8<S>,
    linear: f32x8<S>,
    /// The seen direction in the parameter plane, and its image in pixels.
    v: [f32x8<S>; 2],
    image: [f32x8<S>; 2],
    /// How far the target lies across that image, times its length.
    across: f32x8<S>,
    /// Where all this is needed, and some of the unseen step stays inside the patch.
    pub near: mask32x8<S>,
}

/// `[x_s, y_s]`, `[x_t, y_t]`, the whole step (ds, dt) from (s, t), and the residual in pixels that it should remove.
#[simd]
pub(super) fn fold_step<S: Simd>(
    simd: S,
    surface: &Surface,
    [[a, b], [c, d]]: [[f32x8<S>; 2]; 2],
    whole: [f32x8<S>; 2],
    from: [f32x8<S>; 2],
    [rx, ry]: [f32x8<S>; 2],
) -> FoldStep<S> {
    let zero = f32x8::splat(simd, 0.0);
    let (aa, cc, ac) = (a * a + b * b, c * c + d * d, a * c + b * d);
    // The seen direction is the eigenvector of J^T J with the larger eigenvalue.
    let half = (aa - cc) * 0.5;
    let largest = (aa + cc) * 0.5 + (half * half + ac * ac).sqrt();
    let along_s = aa.simd_ge(cc);
    let v = [along_s.select(largest - cc, ac), along_s.select(ac, largest - aa)];
    let image = [a * v[0] + c * v[1], b * v[0] + d * v[1]];
    let solved = (image[0] * rx + image[1] * ry) / (image[0] * image[0] + image[1] * image[1] + TINY);
    let part = [v[0] * solved, v[1] * solved];
    let unseen = [whole[0] - part[0], whole[1] - part[1]];
    let seen = [from[0] + part[0], from[1] + part[1]];
    // How much of the rest stays inside, and near enough for a parabola to say something.
    let rooms = [room(simd, surface.domain[0], seen[0], unseen[0]), room(simd, surface.domain[1], seen[1], unseen[1])];
    let det = a * d - b * c;
    let degree = surface.degree[0].max(surface.degree[1]) as f32;
    let on_fold = det.abs().simd_lt(largest.sqrt() * (surface.rounding * degree * DERIVATIVE_ROUNDING));
    let one = f32x8::splat(simd, 1.0);
    let limit = on_fold.select(f32x8::splat(simd, f32::MAX), one);
    let fraction = rooms[0].min(rooms[1]).min(limit);
    FoldStep {
        near: (det * det).simd_lt(largest * largest * NEAR_FOLD) & fraction.simd_gt(zero),
        across: image[0] * ry - image[1] * rx,
        bend: [zero; 2],
        seen,
        unseen,
        fraction,
        limit,
        linear: on_fold.select(zero, one),
        v,
        image,
    }
}

/// The parameters of this trial, clamped to the patch.
#[simd]
pub(super) fn trial<S: Simd>(simd: S, step: &FoldStep<S>, surface: &Surface) -> [f32x8<S>; 2] {
    let FoldStep { seen, unseen, bend, fraction, .. } = step;
    let s = seen[0] + (unseen[0] + bend[0] * *fraction) * *fraction;
    let t = seen[1] + (unseen[1] + bend[1] * *fraction) * *fraction;
    [clamp(simd, s, surface.domain[0]), clamp(simd, t, surface.domain[1])]
}

/// The share of a step in one parameter that ends inside the domain and not too far out.
#[simd]
fn room<S: Simd>(simd: S, [low, high]: [f32; 2], from: f32x8<S>, by: f32x8<S>) -> f32x8<S> {
    let ahead = by.simd_gt(f32x8::splat(simd, 0.0)).select(high - from, from - low);
    ahead.min(f32x8::splat(simd, FAR)) / (by.abs() + TINY)
}

/// Within both ends.
#[simd]
pub(super) fn clamp<S: Simd>(simd: S, v: f32x8<S>, [low, high]: [f32; 2]) -> f32x8<S> {
    v.max(f32x8::splat(simd, low)).min(f32x8::splat(simd, high))
}

/// The next trial after one that left the residual (rx, ry); without `solve` just shorter.
#[simd]
pub(super) fn shorten<S: Simd>(simd: S, step: FoldStep<S>, rx: f32x8<S>, ry: f32x8<S>, solve: bool) -> FoldStep<S> {
    let zero = f32x8::splat(simd, 0.0);
    let FoldStep { image, fraction, across, v, bend, limit, linear, .. } = step;
    let by_square = 1.0 / (fraction * fraction);
    // Along the image nothing should be left; across it, what the fraction leaves of the linear part.
    let along = (image[0] * rx + image[1] * ry) * by_square / (image[0] * image[0] + image[1] * image[1] + TINY);
    let curvature = (across * (1.0 - linear * fraction) - (image[0] * ry - image[1] * rx)) * by_square;
    // across (1 - linear f) = curvature f²; without a solution, the nearest that there is: the fold.
    let inside = across * (across * linear + curvature * 4.0);
    let root = across * 2.0 / (across * linear + inside.max(zero).sqrt().copysign(across));
    let best = inside.simd_ge(zero).select(root, across * linear / (curvature * -2.0));
    // Also where there is no number to be had.
    let best = best.simd_ge(fraction * 0.02).select(best, fraction * 0.25);
    FoldStep {
        fraction: if solve { best.min(fraction * 1.5).min(limit) } else { fraction * 0.25 },
        bend: [bend[0] + v[0] * along, bend[1] + v[1] * along],
        ..step
    }
}
