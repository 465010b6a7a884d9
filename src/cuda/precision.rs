//! How exactly a patch is evaluated: the arithmetics of the kernels, and an a-priori bound of the error of each.
//!
//! # The bound
//! A vertex is a quotient of weighted sums of the control points `(X, Y, Z, W)`, which are centred: with `b = B_i(u) B_j(v)`,
//! `x = sum b X / sum b D`, where D is `Z + origin W` in perspective and W in orthographic views. Weights are positive, so
//! `beta = b D / sum b D` are weights of a mean: x is a mean of the projected control points `x_ij`, `|x_ij| <= reach`.
//!
//! Each number is rounded in three steps: to f32 (`u = 2^-24`), to the format of the tensor cores (`p = 2^-11` for f16 and
//! tf32; with recovery `2^-23`, as a low part of 11 bits takes up all but the last of 24), and in the sums. Two kinds of
//! errors come of that:
//! - *shared*: what is wrong with b is wrong in numerator and denominator, `b (1 + d)` with `|d| <= shared`. The mean moves
//!   by at most `shared` times the mean deviation `sum beta |x_ij - x|`, and that is at most `(reach^2 - x^2) / reach`.
//! - *own*: each sum's rest, `|e| <= own sum b |C|`. In the numerator that is at most `own reach` denominators. In the
//!   denominator `|Z| + origin W` stands for `|C|`: at most `cancellation = (origin + |Z / W|) / z_min` denominators, 1 in
//!   orthographic views; depth ratio for a patch centred between its nearest and farthest points.
//!
//! Together, with `a = |x| / reach`: `reach (shared (1 - a^2) + own (1 + cancellation a))`, largest at `a = own cancellation /
//! (2 shared)` or at 1. Patches whose weights all agree are no better off.
//!
//! # What goes into `own`
//! | | f32 | plain | recovered |
//! |---|---|---|---|
//! | the net, to f32 and to the format | u | u, p | u, 2u |
//! | sum over u | (m + 1) u | (m + 6) u | (m + 7) u |
//! | its rounding to the format, the dropped product of low parts | | p | 2u, 4u |
//! | sum over v | (n + 1) u | (n + 6) u | (n + 6) u |
//! | denominator, quotient | 3u | 3u | 3u |
//!
//! A chain of `n + 1` products and sums in f32 errs by `(n + 1) u` of the sum of moduli, fused or not (Higham, Accuracy and
//! Stability of Numerical Algorithms, section 3.1). A tensor core cuts each product, but for one, off at `2^-24` of the largest
//! or lower, and each sum at `2^-23`; sm_80 to sm_89 sum tf32 in two parts (kernels/host/mma.cpp): `(n + 5) u`, however a sparse
//! product is summed. The products
//! with low parts are `2^-11` as large, so what their sums lose is below one more u; `+ 1 u` joins the two halves of the sum
//! over u. `shared` is two roundings of Bernstein values, of u and of v.
//!
//! f16 has few exponents. The kernels scale by powers of two, so that what lies below `2^-20` of the net's largest coordinate,
//! or is a Bernstein value below `2^-23`, loses bits: at most `2^-30` of the largest for the net, `(m + n + 2) 2^-34` for
//! Bernstein values, `2^-39` for what stands between the products. Largest over least denominator, `range`, makes that relative.
//!
//! Depth: `z = origin + Z / W` is such a quotient too, of reach `relief`, and the stored depth is `near / z` or linear in z.
//! Errors are relative in perspective, absolute in orthographic views, where stored depth has a range of 1.
//!
//! Factors `1 + error` multiply to at most `1 + s (1 + s)`, where s is the sum of all errors, below 1: terms of higher order are
//! in. Numbers above 2^100 and below 2^-100 are not. Twin of kernels/precision.cuh: the same numbers, bit for bit.

use super::abi;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Half an ulp of 1 in f32.
const U: f64 = 1.0 / (1 << 24) as f64;
/// The same in f16 and tf32.
const P: f64 = 1.0 / (1 << 11) as f64;
/// Degrees that tensor cores do.
pub const LARGEST_TENSOR_DEGREE: u8 = 7;

/// The arithmetic of one kernel; numbered as in kernels/abi.h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Arithmetic {
    #[default]
    F32 = abi::ArithmeticRule::ARITHMETIC_F32 as isize,
    /// f16 on tensor cores.
    F16 = abi::ArithmeticRule::ARITHMETIC_F16 as isize,
    /// With low parts, as Ootomo and Yokota 2022.
    F16Recovered = abi::ArithmeticRule::ARITHMETIC_F16_RECOVERED as isize,
    /// f16 by products whose left side is half empty: ETER's table 3.
    F16Sparse = abi::ArithmeticRule::ARITHMETIC_F16_SPARSE as isize,
    Tf32 = abi::ArithmeticRule::ARITHMETIC_TF32 as isize,
    Tf32Recovered = abi::ArithmeticRule::ARITHMETIC_TF32_RECOVERED as isize,
}

/// A kernel that evaluates meshlets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kernel {
    arithmetic: Arithmetic,
    /// What f32's loops are unrolled for; 0: any degrees.
    degree: u8,
}

impl Kernel {
    /// By bin of kernels/bins.cu.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let f32s = (0..=LARGEST_TENSOR_DEGREE).map(|degree| Self { arithmetic: Arithmetic::F32, degree });
        let others = Arithmetic::ALL.into_iter().filter(|arithmetic| *arithmetic != Arithmetic::F32);
        f32s.chain(others.map(|arithmetic| Self { arithmetic, degree: 0 }))
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self.arithmetic {
            Arithmetic::F32 if self.degree > 0 => return write!(f, "evaluate_f32_d{}", self.degree),
            Arithmetic::F32 => "evaluate_f32",
            Arithmetic::F16 => "evaluate_f16",
            Arithmetic::F16Recovered => "evaluate_f16_recovered",
            Arithmetic::F16Sparse => "evaluate_f16_sparse",
            Arithmetic::Tf32 => "evaluate_tf32",
            Arithmetic::Tf32Recovered => "evaluate_tf32_recovered",
        })
    }
}

/// What a bound needs to know of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hull {
    pub degree: [u8; 2],
    /// Pixels, in x or y, between the centre and the farthest control point.
    pub reach: f64,
    /// Largest denominator of a control point over the least.
    pub range: f64,
    /// `(origin + |z - origin|) / z_min` in perspective, 1 in orthographic views.
    pub cancellation: f64,
    /// `|z - origin|` at most: over z_min in perspective, as stored depth in orthographic views.
    pub relief: f64,
}

/// What a vertex may be off by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// Pixels in x and in y, before snapping.
    pub place: f64,
    /// Of the stored depth: relative in perspective, absolute in orthographic views.
    pub depth: f64,
    /// Relative, of `1 / denominator`.
    pub weight: f64,
}

impl Hull {
    /// Of a net as the kernels get it.
    pub fn new(view: &abi::View, patch: &abi::Patch, net: &[abi::Point]) -> Self {
        let perspective = view.perspective != 0;
        let origin = f64::from(patch.depth_origin);
        let (mut reach, mut relief) = (0.0_f64, 0.0_f64);
        let (mut denominators, mut nearest) = ([f64::INFINITY, 0.0_f64], f64::INFINITY);
        for p in net {
            let [x, y, z, w] = [p.x, p.y, p.z, p.w].map(f64::from);
            let d = if perspective { z + origin * w } else { w };
            reach = reach.max(x.abs().max(y.abs()) / d);
            relief = relief.max(z.abs() / w);
            nearest = nearest.min(origin + z / w);
            denominators = [denominators[0].min(d), denominators[1].max(d)];
        }
        // These points have been rounded to f32 already; `own` counts from the exact ones.
        let grow = 1.0 + 16.0 * U;
        let range = denominators[1] / denominators[0] * grow;
        Self::of(view, patch.degree, [reach * grow, range], [nearest, origin, relief * grow])
    }

    /// `[reach, range]`, and camera depths: of the nearest control point, that the net is centred on, and how far one is from
    /// that at most.
    pub(crate) fn of(
        view: &abi::View,
        degree: [u8; 2],
        [reach, range]: [f64; 2],
        [nearest, origin, relief]: [f64; 3],
    ) -> Self {
        let (cancellation, relief) = if view.perspective != 0 {
            ((origin + relief) / nearest, relief / nearest)
        } else {
            (1.0, relief * f64::from(view.depth_slope))
        };
        Self { degree, reach, range, cancellation, relief }
    }
}

impl Arithmetic {
    pub const ALL: [Self; 6] =
        [Self::F32, Self::F16, Self::F16Recovered, Self::F16Sparse, Self::Tf32, Self::Tf32Recovered];

    /// The kernel for patches of a degree.
    pub fn kernel(self, degree: [u8; 2]) -> Kernel {
        let [u, v] = degree;
        let arithmetic = self.for_degree(degree);
        let unrolled = arithmetic == Self::F32 && u == v && (1..=LARGEST_TENSOR_DEGREE).contains(&u);
        Kernel { arithmetic, degree: if unrolled { u } else { 0 } }
    }

    /// This, where tensor cores can do it.
    pub fn for_degree(self, degree: [u8; 2]) -> Self {
        if degree.iter().all(|d| (1..=LARGEST_TENSOR_DEGREE).contains(d)) { self } else { Self::F32 }
    }

    /// By its number in kernels/abi.h.
    pub fn numbered(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// The a-priori bound; see the top of this file.
    pub fn bound(self, hull: &Hull) -> Bound {
        let (shared, relative) = self.for_degree(hull.degree).errors(hull.degree);
        let vanishing = self.vanishing(hull.degree);
        let own = relative + vanishing * hull.range;
        // Denominators of the mean that is Z / W: the weights alone.
        let own_depth = relative + vanishing * hull.range * hull.cancellation;
        let relief = hull.relief * mean_error(shared, own_depth, 1.0);
        Bound {
            place: hull.reach * mean_error(shared, own, hull.cancellation),
            depth: quotient(relief) + (4.0 + 2.0 * hull.cancellation) * U,
            weight: quotient(shared + own * hull.cancellation),
        }
    }

    /// `shared` and the relative part of `own`.
    fn errors(self, [m, n]: [u8; 2]) -> (f64, f64) {
        let grown = |errors: f64| errors * (1.0 + errors);
        let degrees = f64::from(m) + f64::from(n);
        match self {
            Self::F32 => (grown(2.0 * U), grown((degrees + 6.0) * U)),
            Self::F16 | Self::F16Sparse | Self::Tf32 => {
                (grown(2.0 * U + 2.0 * P), grown((degrees + 16.0) * U + 2.0 * P))
            }
            Self::F16Recovered | Self::Tf32Recovered => (grown(6.0 * U), grown((degrees + 25.0) * U)),
        }
    }

    /// What f16's subnormal numbers lose, of the largest coordinate.
    fn vanishing(self, [m, n]: [u8; 2]) -> f64 {
        match self.for_degree([m, n]) {
            Self::F16 | Self::F16Recovered | Self::F16Sparse => {
                0.5_f64.powi(30) + (f64::from(m) + f64::from(n) + 2.0) * 0.5_f64.powi(34) + 0.5_f64.powi(38)
            }
            _ => 0.0,
        }
    }
}

impl Bound {
    /// Pixels that a pixel's parameter may be off by beside: barycentric coordinates are weighted by what vertices carry.
    pub fn parameter(&self, view: &abi::View, reach: f64) -> f64 {
        let weight = match (view.projective != 0, view.perspective != 0) {
            (true, _) => self.weight,
            (false, true) => self.depth,
            (false, false) => 0.0,
        };
        // Half of what lies between the vertices of a triangle, as `shared` moves a mean.
        reach * quotient(weight)
    }

    /// Camera depth in pixel sizes.
    pub fn depth_in_pixels(&self, view: &abi::View) -> f64 {
        self.depth * view.scale * if view.perspective != 0 { 1.0 } else { view.extent }
    }
}

/// Error of a mean of numbers up to 1.
fn mean_error(shared: f64, own: f64, cancellation: f64) -> f64 {
    let a = (own * cancellation / (2.0 * shared)).min(1.0);
    let first_order = shared * (1.0 - a * a) + own * (1.0 + cancellation * a);
    let higher = 1.0 - 2.0 * cancellation * (shared + own);
    if higher > 0.0 { first_order / higher } else { f64::INFINITY }
}

/// Relative error of a quotient whose divisor errs by `e`.
fn quotient(e: f64) -> f64 {
    if e < 1.0 { e / (1.0 - e) } else { f64::INFINITY }
}
