// Refinement: from a pixel's interpolated parameter to the exact surface point under its centre (DESIGN section 4,
// "Refinement"; research "crack-closing", section 2, rule 6). Twin of src/stages/newton.rs, a thread a pixel.
#pragma once
#include "fold_step.cuh"

namespace refinement {

// Residual in pixels at which a pixel is done.
constexpr float CONVERGED = 1.0f / 512.0f;
// Times a step is halved before the old parameter is kept.
constexpr int HALVINGS = 8;
// The same where many starts are tried, most of them in vain.
constexpr int SEARCH_HALVINGS = 3;
// Trials near a fold that must gain one half.
constexpr int PARABOLAS = 4;
// Rounds that pixels near a silhouette, where Newton's method is slow, may take for each one asked for.
constexpr uint32_t STRAGGLER_ROUNDS = 8;
// Sine of the angle in the image between the derivatives from which on a surface clearly shows one side.
constexpr float SIDEWAYS = 1e-3f;

// Where refinement has come to.
struct Refined {
    float s, t;
    // L-infinity distance of the projected surface point from the pixel centre.
    float residual;
    PatchPoint point;

    // It shows the inside of a solid, whose hidden sense of rotation is `hidden`; 0 hides nothing.
    __device__ __forceinline__ bool faces_away(int hidden) const {
        const float a = point.ds[0], b = point.ds[1], c = point.dt[0], d = point.dt[1];
        return (a * d - b * c) * float(hidden) > SIDEWAYS * sqrtf((a * a + b * b) * (c * c + d * d));
    }
};

// Sign of the map from parameters to pixels: which side of the surface faces the eye.
static __device__ __forceinline__ float jacobian(const PatchPoint &p) { return p.ds[0] * p.dt[1] - p.dt[0] * p.ds[1]; }

// What the depth may change: the tolerance, and twice what the surface's own slope explains.
static __device__ __forceinline__ float slope_allowance(const Surface &surface, const PatchPoint &p, float x, float y) {
    const float rx = x - p.x, ry = y - p.y;
    // (ds, dt) = J^-1 r; dz = z_s ds + z_t dt.
    const float a = rx * p.dt[1] - ry * p.dt[0];
    const float b = ry * p.ds[0] - rx * p.ds[1];
    const float along = fabsf((p.ds[2] * a + p.dt[2] * b) / jacobian(p));
    return (along < LARGEST ? along : 0.0f) * 2.0f + surface.depth_tolerance;
}

struct Step {
    float2 next;
    FoldStep fold;
};

// One damped Gauss-Newton step, clamped to the patch; where one parameter meets its end the other is solved again. With what
// is needed beside a fold.
static __device__ __forceinline__ Step step(const Surface &surface, const PatchPoint &p, float s, float t, float x, float y) {
    const float rx = x - p.x, ry = y - p.y;
    const float a = p.ds[0], b = p.ds[1], c = p.dt[0], d = p.dt[1];
    const float aa = a * a + b * b, cc = c * c + d * d, ac = a * c + b * d;
    const float ga = a * rx + b * ry, gc = c * rx + d * ry;
    const float det = aa * cc - ac * ac;
    // A little damping keeps edge-on points finite and leaves all others as they are.
    const float damped = det + (aa + cc) * (aa + cc) * 1e-7f + TINY;
    const float exact = a * d - b * c;
    const bool regular = exact * exact > (aa + cc) * (aa + cc) * 1e-11f;
    const float inverse = regular ? exact : damped;
    const float ds = (regular ? rx * d - ry * c : cc * ga - ac * gc) / inverse;
    const float dt = (regular ? ry * a - rx * b : aa * gc - ac * ga) / inverse;
    const float ns = s + ds, nt = t + dt;
    const float ks = clamp(ns, surface.domain[0]), kt = clamp(nt, surface.domain[1]);
    // The other parameter, solved again with the clamped one held.
    const float ts = clamp(t + (gc - ac * (ks - s)) / (cc + TINY), surface.domain[1]);
    const float st = clamp(s + (ga - ac * (kt - t)) / (aa + TINY), surface.domain[0]);
    const bool s_met = !(ks == ns), t_met = !(kt == nt);
    // Both met their ends: the better of the two, by what the linear model leaves.
    const auto left = [&](float ds, float dt) {
        return larger(fabsf(rx - a * ds - c * dt), fabsf(ry - b * ds - d * dt));
    };
    const bool hold_s = s_met && (!t_met || left(ks - s, ts - t) <= left(st - s, kt - t));
    const bool hold_t = t_met && !hold_s;
    Step out;
    out.next = make_float2(hold_t ? st : ks, hold_s ? ts : kt);
    out.fold.near = false;
    // The trace bounds the larger eigenvalue that `near` asks about.
    if (exact * exact < (aa + cc) * (aa + cc) * NEAR_FOLD) {
        out.fold = fold_step(surface, a, b, c, d, ds, dt, s, t, rx, ry);
        if (out.fold.near) {
            out.next = trial(out.fold, surface);
        }
    }
    return out;
}

// One round: the step, halved until the residual falls.
static __device__ __forceinline__ void round(const Surface &surface, float x, float y, float facing, Refined &r) {
    const float depth = r.point.z;
    const float slack = slope_allowance(surface, r.point, x, y);
    Step next = step(surface, r.point, r.s, r.t, x, y);
    for (int halving = 0; halving <= (surface.any_sheet ? SEARCH_HALVINGS : HALVINGS); halving++) {
        const PatchPoint point = patch_point::at(surface, next.next.x, next.next.y);
        const float rx = x - point.x, ry = y - point.y;
        const float residual = larger(fabsf(rx), fabsf(ry));
        // Near a fold the next trial knows the curvature: what gains little waits for it.
        const bool waits = next.fold.near && halving < PARABOLAS;
        bool take = residual < (waits ? r.residual * 0.5f : r.residual);
        // Another sheet, or the other side of a silhouette, is not this pixel's surface.
        if (!surface.any_sheet) {
            take = take && jacobian(point) * facing >= 0.0f && fabsf(point.z - depth) <= slack;
        }
        if (take) {
            r.s = next.next.x;
            r.t = next.next.y;
            r.residual = residual;
            r.point = point;
            return;
        }
        if (next.fold.near) {
            shorten(next.fold, rx, ry, halving < PARABOLAS);
            next.next = trial(next.fold, surface);
        } else {
            next.next = make_float2((r.s + next.next.x) * 0.5f, (r.t + next.next.y) * 0.5f);
        }
    }
}

// From (s, t) towards the pixel centre (x, y), given about the patch's own, with at most `rounds` regular rounds.
inline __device__ __noinline__ Refined refine(const Surface &surface, uint32_t rounds, float s, float t, float x,
                                              float y) {
    Refined r;
    r.s = s;
    r.t = t;
    r.point = patch_point::at(surface, s, t);
    r.residual = larger(fabsf(x - r.point.x), fabsf(y - r.point.y));
    const float facing = jacobian(r.point);
    for (uint32_t k = 0; k < rounds * STRAGGLER_ROUNDS && r.residual > CONVERGED; k++) {
        const float before = r.residual;
        round(surface, x, y, facing, r);
        // Past the regular rounds only those go on that still get somewhere.
        if (k + 1 >= rounds && !(r.residual < before * 0.9f)) {
            break;
        }
    }
    return r;
}

// A pixel's centre about the patch's.
static __device__ __forceinline__ float2 target(const View &view, const Leaf &leaf, int x, int y) {
    return make_float2(float(x) + 0.5f - float(view.size[0]) * 0.5f - float(leaf.center[0]),
                       float(y) + 0.5f - float(view.size[1]) * 0.5f - float(leaf.center[1]));
}

} // namespace refinement
