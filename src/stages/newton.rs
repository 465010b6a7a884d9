//! Refinement: from a pixel's interpolated parameter to the exact surface point under its centre, eight pixels of one
//! leaf at a time (DESIGN section 4, "Refinement"; research "crack-closing", section 2, rule 6).

use super::fold_step::{FoldStep, NEAR_FOLD, clamp, fold_step, shorten, trial};
use fearless_simd::{f32x8, mask32x8, prelude::*};
use fearless_simd_macros::simd;
use glam::Vec4;

pub(super) const LANES: usize = 8;
/// Residual in pixels at which a pixel is done.
pub const CONVERGED: f32 = 1.0 / 512.0;
/// Times a step is halved before the old parameter is kept.
const HALVINGS: usize = 8;
/// The same where many starts are tried, most of them in vain.
const SEARCH_HALVINGS: usize = 3;
/// Trials near a fold that must gain one half.
const PARABOLAS: usize = 4;
/// Rounds that pixels near a silhouette, where Newton's method is slow, may take for each one asked for.
const STRAGGLER_ROUNDS: u32 = 8;

/// A leaf as refinement sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface<'a> {
    pub net: &'a [Vec4],
    pub degree: [usize; 2],
    pub rational: bool,
    pub perspective: bool,
    pub depth_origin: f32,
    /// What rounding may move a point, in pixels.
    pub rounding: f32,
    /// Parameters of the leaf that lie in its patch: lower and upper ends.
    pub domain: [[f32; 2]; 2],
    /// What the depth may change beyond the surface's own slope, model units.
    pub depth_tolerance: f32,
    /// Any sheet will do: refinement may cross silhouettes and change the depth.
    pub any_sheet: bool,
}

/// Eight pixels: parameters in and out, targets in, surface out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Batch {
    pub s: [f32; LANES],
    pub t: [f32; LANES],
    /// Pixel centres about the leaf's centre.
    pub x: [f32; LANES],
    pub y: [f32; LANES],
    /// L-infinity distance of the projected surface point from the pixel centre.
    pub residual: [f32; LANES],
    /// Camera depth of the surface point about the leaf's depth origin.
    pub z: [f32; LANES],
    /// `S_u x S_v` up to a positive factor, in the leaf's pixel-homogeneous axes.
    pub normal: [[f32; LANES]; 3],
    /// Derivatives of x, y (pixels) and z (units) by s and by t.
    pub ds: [[f32; LANES]; 3],
    pub dt: [[f32; LANES]; 3],
}

/// Sine of the angle in the image between the derivatives from which on a surface clearly shows one side.
const SIDEWAYS: f32 = 1e-3;

impl Batch {
    /// Lane k shows the inside of a solid, whose hidden sense of rotation is `hidden`; 0 hides nothing.
    pub fn faces_away(&self, k: usize, hidden: i8) -> bool {
        let [a, b, c, d] = [self.ds[0][k], self.ds[1][k], self.dt[0][k], self.dt[1][k]];
        let sideways = SIDEWAYS * ((a * a + b * b) * (c * c + d * d)).sqrt();
        (a * d - b * c) * f32::from(hidden) > sideways
    }
}

/// The surface at eight parameters, divided: position (x, y in pixels, z about the depth origin) and derivatives.
struct Point<S: Simd> {
    x: f32x8<S>,
    y: f32x8<S>,
    z: f32x8<S>,
    /// Pixel-space derivatives: [x, y, z] by s, then by t.
    ds: [f32x8<S>; 3],
    dt: [f32x8<S>; 3],
    normal: [f32x8<S>; 3],
}

/// Refines a batch in place with at most `rounds` regular rounds.
#[simd]
pub(super) fn refine<S: Simd>(simd: S, surface: &Surface, rounds: u32, batch: &mut Batch) {
    // Sizes are fixed at compile time: up to bicubic, everything unrolls and stays in registers.
    match surface.degree[0].max(surface.degree[1]) {
        0..=3 => refine_sized::<S, 4>(simd, surface, rounds, batch),
        4..=7 => refine_sized::<S, 8>(simd, surface, rounds, batch),
        _ => refine_sized::<S, 64>(simd, surface, rounds, batch),
    }
}

#[simd]
fn refine_sized<S: Simd, const N: usize>(simd: S, surface: &Surface, rounds: u32, batch: &mut Batch) {
    let cubic = if N == 4 { Cubic::new(surface) } else { Cubic::default() };
    let (x, y) = (f32x8::from_slice(simd, &batch.x), f32x8::from_slice(simd, &batch.y));
    let (mut s, mut t) = (f32x8::from_slice(simd, &batch.s), f32x8::from_slice(simd, &batch.t));
    let mut point = evaluate::<S, N>(simd, surface, &cubic, s, t);
    let mut residual = (x - point.x).abs().max((y - point.y).abs());
    let facing = jacobian(simd, &point);
    // Each pixel goes on by itself: what it ends with does not depend on its neighbours.
    let mut open = residual.simd_gt(f32x8::splat(simd, CONVERGED));
    let mut round = 0;
    while round < rounds * STRAGGLER_ROUNDS && open.any_true() {
        let before = residual;
        let depth = point.z;
        let slack = slope_allowance(simd, surface, &point, x, y);
        let ([mut ns, mut nt], mut fold) = step(simd, surface, &point, open, [s, t], [x, y]);
        let mut pending = open;
        for halving in 0..=if surface.any_sheet { SEARCH_HALVINGS } else { HALVINGS } {
            let next = evaluate::<S, N>(simd, surface, &cubic, ns, nt);
            let (rx, ry) = (x - next.x, y - next.y);
            let r = rx.abs().max(ry.abs());
            // Near a fold the next trial knows the curvature: what gains little waits for it.
            let enough = match &fold {
                Some(fold) if halving < PARABOLAS => fold.near.select(residual * 0.5, residual),
                _ => residual,
            };
            // Another sheet, or the other side of a silhouette, is not this pixel's surface.
            let same_side = (jacobian(simd, &next) * facing).simd_ge(f32x8::splat(simd, 0.0));
            let same_sheet = (next.z - depth).abs().simd_le(slack);
            let mut take = pending & r.simd_lt(enough);
            if !surface.any_sheet {
                take = take & same_side & same_sheet;
            }
            s = take.select(ns, s);
            t = take.select(nt, t);
            residual = take.select(r, residual);
            point = merge(simd, take, next, point);
            pending &= !take;
            if !pending.any_true() {
                break;
            }
            let mut half = [(s + ns) * 0.5, (t + nt) * 0.5];
            if let Some(last) = fold {
                let shorter = shorten(simd, last, rx, ry, halving < PARABOLAS);
                half = beside_fold(simd, &shorter, surface, half);
                fold = Some(shorter);
            }
            ns = pending.select(half[0], ns);
            nt = pending.select(half[1], nt);
        }
        round += 1;
        open &= residual.simd_gt(f32x8::splat(simd, CONVERGED));
        // Past the regular rounds only those go on that still get somewhere.
        if round >= rounds {
            open &= residual.simd_lt(before * 0.9);
        }
    }
    s.store_slice(&mut batch.s);
    t.store_slice(&mut batch.t);
    residual.store_slice(&mut batch.residual);
    point.z.store_slice(&mut batch.z);
    for k in 0..3 {
        point.normal[k].store_slice(&mut batch.normal[k]);
        point.ds[k].store_slice(&mut batch.ds[k]);
        point.dt[k].store_slice(&mut batch.dt[k]);
    }
}

/// Sign of the map from parameters to pixels: which side of the surface faces the eye.
#[simd]
fn jacobian<S: Simd>(_: S, p: &Point<S>) -> f32x8<S> {
    p.ds[0] * p.dt[1] - p.dt[0] * p.ds[1]
}

/// What the depth may change: the tolerance, and twice what the surface's own slope explains.
#[simd]
fn slope_allowance<S: Simd>(simd: S, surface: &Surface, p: &Point<S>, x: f32x8<S>, y: f32x8<S>) -> f32x8<S> {
    let det = jacobian(simd, p);
    let (rx, ry) = (x - p.x, y - p.y);
    // (ds, dt) = J^-1 r; dz = z_s ds + z_t dt.
    let a = rx * p.dt[1] - ry * p.dt[0];
    let b = ry * p.ds[0] - rx * p.ds[1];
    let along = ((p.ds[2] * a + p.dt[2] * b) / det).abs();
    let along = along.simd_lt(f32x8::splat(simd, f32::MAX)).select(along, f32x8::splat(simd, 0.0));
    along * 2.0 + surface.depth_tolerance
}

/// The trial of a fold step where it is needed, else `plain`.
#[simd]
fn beside_fold<S: Simd>(simd: S, fold: &FoldStep<S>, surface: &Surface, plain: [f32x8<S>; 2]) -> [f32x8<S>; 2] {
    let folded = trial(simd, fold, surface);
    [fold.near.select(folded[0], plain[0]), fold.near.select(folded[1], plain[1])]
}

/// One damped Gauss-Newton step, clamped to the patch; where one parameter meets its end the other is solved again. With
/// what is needed beside a fold, where an open lane may be there.
#[simd]
fn step<S: Simd>(
    simd: S,
    surface: &Surface,
    p: &Point<S>,
    open: mask32x8<S>,
    [s, t]: [f32x8<S>; 2],
    [x, y]: [f32x8<S>; 2],
) -> ([f32x8<S>; 2], Option<FoldStep<S>>) {
    let (rx, ry) = (x - p.x, y - p.y);
    let (a, b) = (p.ds[0], p.ds[1]);
    let (c, d) = (p.dt[0], p.dt[1]);
    let aa = a * a + b * b;
    let cc = c * c + d * d;
    let ac = a * c + b * d;
    let (ga, gc) = (a * rx + b * ry, c * rx + d * ry);
    let det = aa * cc - ac * ac;
    // A little damping keeps edge-on points finite and leaves all others as they are.
    let damped = det + (aa + cc) * (aa + cc) * 1e-7 + 1e-30;
    let exact = a * d - b * c;
    let regular = (exact * exact).simd_gt((aa + cc) * (aa + cc) * 1e-11);
    let inverse = regular.select(exact, damped);
    let ds = regular.select(rx * d - ry * c, cc * ga - ac * gc) / inverse;
    let dt = regular.select(ry * a - rx * b, aa * gc - ac * ga) / inverse;
    let [range_s, range_t] = surface.domain;
    let (ns, nt) = (s + ds, t + dt);
    let (ks, kt) = (clamp(simd, ns, range_s), clamp(simd, nt, range_t));
    // The other parameter, solved again with the clamped one held.
    let tiny = 1e-30;
    let ts = clamp(simd, t + (gc - ac * (ks - s)) / (cc + tiny), range_t);
    let st = clamp(simd, s + (ga - ac * (kt - t)) / (aa + tiny), range_s);
    let s_met = !ks.simd_eq(ns);
    let t_met = !kt.simd_eq(nt);
    // Both met their ends: the better of the two, by what the linear model leaves.
    let by_s = left(simd, [a, b, c, d], [rx, ry], [ks - s, ts - t]);
    let by_t = left(simd, [a, b, c, d], [rx, ry], [st - s, kt - t]);
    let hold_s = s_met & (!t_met | by_s.simd_le(by_t));
    let hold_t = t_met & !hold_s;
    let plain = [hold_t.select(st, ks), hold_s.select(ts, kt)];
    // The trace bounds the larger eigenvalue that `near` asks about.
    let maybe_near = open & (exact * exact).simd_lt((aa + cc) * (aa + cc) * NEAR_FOLD);
    if !maybe_near.any_true() {
        return (plain, None);
    }
    let fold = fold_step(simd, surface, [[a, b], [c, d]], [ds, dt], [s, t], [rx, ry]);
    (beside_fold(simd, &fold, surface, plain), Some(fold))
}

/// What a step leaves of a residual by the linear model.
#[simd]
fn left<S: Simd>(_: S, [a, b, c, d]: [f32x8<S>; 4], [rx, ry]: [f32x8<S>; 2], [ds, dt]: [f32x8<S>; 2]) -> f32x8<S> {
    (rx - a * ds - c * dt).abs().max((ry - b * ds - d * dt).abs())
}

#[simd]
fn merge<S: Simd>(simd: S, take: mask32x8<S>, a: Point<S>, b: Point<S>) -> Point<S> {
    Point {
        x: take.select(a.x, b.x),
        y: take.select(a.y, b.y),
        z: take.select(a.z, b.z),
        ds: three(simd, take, a.ds, b.ds),
        dt: three(simd, take, a.dt, b.dt),
        normal: three(simd, take, a.normal, b.normal),
    }
}

#[simd]
fn three<S: Simd>(_: S, take: mask32x8<S>, a: [f32x8<S>; 3], b: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
    [take.select(a[0], b[0]), take.select(a[1], b[1]), take.select(a[2], b[2])]
}

#[simd]
fn evaluate<S: Simd, const N: usize>(simd: S, surface: &Surface, cubic: &Cubic, s: f32x8<S>, t: f32x8<S>) -> Point<S> {
    if N == 4 { cubic_point(simd, surface, cubic, s, t) } else { point::<S, N>(simd, surface, s, t) }
}

/// A net of degree up to 3 x 3, padded with zeros, a coordinate at a time.
#[derive(Default)]
struct Cubic([[f32; 16]; 4]);

impl Cubic {
    fn new(surface: &Surface) -> Self {
        let mut net = [[0.0; 16]; 4];
        for (i, row) in surface.net.chunks_exact(surface.degree[1] + 1).enumerate() {
            for (j, point) in row.iter().enumerate() {
                for (c, coordinate) in net.iter_mut().enumerate() {
                    coordinate[4 * i + j] = point[c];
                }
            }
        }
        Self(net)
    }
}

#[simd]
fn cubic_point<S: Simd>(simd: S, surface: &Surface, cubic: &Cubic, s: f32x8<S>, t: f32x8<S>) -> Point<S> {
    let [m, n] = surface.degree;
    let (bu, du) = cubic_basis(simd, m, s);
    let (bv, dv) = cubic_basis(simd, n, t);
    let zero = f32x8::splat(simd, 0.0);
    let (mut p, mut ps, mut pt) = ([zero; 4], [zero; 4], [zero; 4]);
    // Polynomial nets have one weight; its derivatives are zero.
    p[3] = f32x8::splat(simd, cubic.0[3][0]);
    let used = if surface.rational { 4 } else { 3 };
    for c in 0..used {
        let q = &cubic.0[c];
        let (mut sum, mut sum_s, mut sum_t) = (zero, zero, zero);
        for i in 0..4 {
            let (mut value, mut derivative) = (zero, zero);
            for j in 0..4 {
                let q = f32x8::splat(simd, q[4 * i + j]);
                value += bv[j] * q;
                derivative += dv[j] * q;
            }
            sum += bu[i] * value;
            sum_s += du[i] * value;
            sum_t += bu[i] * derivative;
        }
        p[c] = sum;
        ps[c] = sum_s;
        pt[c] = sum_t;
    }
    divide(simd, surface, p, ps, pt)
}

/// Values and derivatives of the Bernstein polynomials of degree 1, 2 or 3; those beyond the degree are zero.
#[simd]
fn cubic_basis<S: Simd>(simd: S, degree: usize, t: f32x8<S>) -> ([f32x8<S>; 4], [f32x8<S>; 4]) {
    let zero = f32x8::splat(simd, 0.0);
    let one = f32x8::splat(simd, 1.0);
    let r = one - t;
    match degree {
        0 => ([one, zero, zero, zero], [zero; 4]),
        1 => ([r, t, zero, zero], [-one, one, zero, zero]),
        2 => ([r * r, r * t * 2.0, t * t, zero], [r * -2.0, (r - t) * 2.0, t * 2.0, zero]),
        _ => {
            let (rr, rt, tt) = (r * r, r * t, t * t);
            let values = [rr * r, rt * r * 3.0, rt * t * 3.0, tt * t];
            (values, [rr * -3.0, (rr - rt * 2.0) * 3.0, (rt * 2.0 - tt) * 3.0, tt * 3.0])
        }
    }
}

/// Values and derivatives of the Bernstein polynomials of degree `values.len() - 1` (the first of `N`).
#[simd]
fn basis<S: Simd, const N: usize>(simd: S, degree: usize, t: f32x8<S>) -> ([f32x8<S>; N], [f32x8<S>; N]) {
    let zero = f32x8::splat(simd, 0.0);
    let mut low = [zero; N];
    low[0] = f32x8::splat(simd, 1.0);
    let other = 1.0 - t;
    for d in 1..degree {
        let mut carried = zero;
        for value in &mut low[..d] {
            let old = *value;
            *value = carried + other * old;
            carried = t * old;
        }
        low[d] = carried;
    }
    // Degree - 1 gives the derivative; one more step the values.
    let (mut values, mut derivatives) = ([zero; N], [zero; N]);
    let mut before = zero;
    for i in 0..=degree {
        let here = if i < degree { low[i] } else { zero };
        values[i] = t * before + other * here;
        derivatives[i] = (before - here) * degree as f32;
        before = here;
    }
    (values, derivatives)
}

#[simd]
fn point<S: Simd, const N: usize>(simd: S, surface: &Surface, s: f32x8<S>, t: f32x8<S>) -> Point<S> {
    let [m, n] = surface.degree;
    let (bu, du) = basis::<S, N>(simd, m, s);
    let (bv, dv) = basis::<S, N>(simd, n, t);
    let zero = f32x8::splat(simd, 0.0);
    let (mut p, mut ps, mut pt) = ([zero; 4], [zero; 4], [zero; 4]);
    let used = if surface.rational { 4 } else { 3 };
    for i in 0..=m {
        let row = &surface.net[i * (n + 1)..(i + 1) * (n + 1)];
        for c in 0..used {
            let (mut value, mut derivative) = (zero, zero);
            for j in 0..=n {
                let q = row[j][c];
                value += bv[j] * q;
                derivative += dv[j] * q;
            }
            p[c] += bu[i] * value;
            ps[c] += du[i] * value;
            pt[c] += bu[i] * derivative;
        }
    }
    if !surface.rational {
        // Polynomial nets have one weight; its derivatives are zero.
        p[3] = f32x8::splat(simd, surface.net[0].w);
    }
    divide(simd, surface, p, ps, pt)
}

/// The quotient rule, on the screen and for the normal.
#[simd]
fn divide<S: Simd>(simd: S, surface: &Surface, p: [f32x8<S>; 4], ps: [f32x8<S>; 4], pt: [f32x8<S>; 4]) -> Point<S> {
    let z0 = surface.depth_origin;
    let denominator = |q: &[f32x8<S>; 4]| if surface.perspective { q[2] + q[3] * z0 } else { q[3] };
    let one = f32x8::splat(simd, 1.0);
    let inverse = one / denominator(&p);
    let (d_s, d_t) = (denominator(&ps), denominator(&pt));
    let (x, y) = (p[0] * inverse, p[1] * inverse);
    let by_weight = one / p[3];
    let z = p[2] * by_weight;
    // Tangents in the leaf's affine axes, for the normal.
    let at = [p[0] * by_weight, p[1] * by_weight, z];
    let (a, b) = (tangent(simd, &ps, at, by_weight), tangent(simd, &pt, at, by_weight));
    let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    Point {
        x,
        y,
        z,
        ds: [(ps[0] - x * d_s) * inverse, (ps[1] - y * d_s) * inverse, a[2]],
        dt: [(pt[0] - x * d_t) * inverse, (pt[1] - y * d_t) * inverse, b[2]],
        normal,
    }
}

/// A derivative divided by the weight, where the surface is `at`.
#[simd]
fn tangent<S: Simd>(_: S, q: &[f32x8<S>; 4], at: [f32x8<S>; 3], by_weight: f32x8<S>) -> [f32x8<S>; 3] {
    [(q[0] - at[0] * q[3]) * by_weight, (q[1] - at[1] * q[3]) * by_weight, (q[2] - at[2] * q[3]) * by_weight]
}
