// Part of refinement: Newton's method beside a fold of the surface's image, where the map from parameters to pixels is
// nearly singular. The direction it sees well is taken whole, the other by a fraction, along a parabola that trials bend.
// Twin of src/stages/fold_step.rs, which says why.
#pragma once
#include "patch_point.cuh"

namespace refinement {

// Squared ratio of the singular values below which the map counts as nearly singular.
constexpr float NEAR_FOLD = 1.0f / 16.0f;
// Patch parameters that a parabola is trusted for.
constexpr float FAR_OUT = 0.25f;
constexpr float TINY = 1e-30f;
// Derivatives are off by the degree times what a point is off by; times four, to be sure.
constexpr float DERIVATIVE_ROUNDING = 4.0f;
constexpr float LARGEST = 3.4028234663852886e38f;

// seen + unseen f + bend f^2 for fractions f of the unseen part.
struct FoldStep {
    float seen[2], unseen[2], bend[2];
    float fraction;
    // The largest fraction, and what of `across` the whole unseen part should remove: one, and one; on the fold nothing is
    // known of either.
    float limit, linear;
    // The seen direction in the parameter plane, and its image in pixels.
    float v[2], image[2];
    // How far the target lies across that image, times its length.
    float across;
    // All this is needed, and some of the unseen step stays inside the patch.
    bool near;
};

static __device__ __forceinline__ float clamp(float v, const float (&ends)[2]) { return smaller(larger(v, ends[0]), ends[1]); }

// The share of a step in one parameter that ends inside the domain and not too far out.
static __device__ __forceinline__ float room(const float (&ends)[2], float from, float by) {
    const float ahead = by > 0.0f ? ends[1] - from : from - ends[0];
    return smaller(ahead, FAR_OUT) / (fabsf(by) + TINY);
}

// a, b: x and y by s; c, d: by t; the whole step from (s, t), and the residual in pixels that it should remove.
static __device__ __forceinline__ FoldStep fold_step(const Surface &surface, float a, float b, float c, float d, float ds,
                                                     float dt, float s, float t, float rx, float ry) {
    const float aa = a * a + b * b, cc = c * c + d * d, ac = a * c + b * d;
    // The seen direction is the eigenvector of J^T J with the larger eigenvalue.
    const float half = (aa - cc) * 0.5f;
    const float largest = (aa + cc) * 0.5f + sqrtf(half * half + ac * ac);
    const bool along_s = aa >= cc;
    FoldStep f;
    f.v[0] = along_s ? largest - cc : ac;
    f.v[1] = along_s ? ac : largest - aa;
    f.image[0] = a * f.v[0] + c * f.v[1];
    f.image[1] = b * f.v[0] + d * f.v[1];
    const float solved =
        (f.image[0] * rx + f.image[1] * ry) / (f.image[0] * f.image[0] + f.image[1] * f.image[1] + TINY);
    const float part[2] = {f.v[0] * solved, f.v[1] * solved};
    f.unseen[0] = ds - part[0];
    f.unseen[1] = dt - part[1];
    f.seen[0] = s + part[0];
    f.seen[1] = t + part[1];
    // How much of the rest stays inside, and near enough for a parabola to say something.
    const float room_s = room(surface.domain[0], f.seen[0], f.unseen[0]);
    const float room_t = room(surface.domain[1], f.seen[1], f.unseen[1]);
    const float det = a * d - b * c;
    const float degree = float(max(surface.degree[0], surface.degree[1]));
    const bool on_fold = fabsf(det) < sqrtf(largest) * (surface.rounding * degree * DERIVATIVE_ROUNDING);
    f.limit = on_fold ? LARGEST : 1.0f;
    f.fraction = smaller(smaller(room_s, room_t), f.limit);
    f.near = det * det < largest * largest * NEAR_FOLD && f.fraction > 0.0f;
    f.across = f.image[0] * ry - f.image[1] * rx;
    f.bend[0] = f.bend[1] = 0.0f;
    f.linear = on_fold ? 0.0f : 1.0f;
    return f;
}

// The parameters of this trial, clamped to the patch.
static __device__ __forceinline__ float2 trial(const FoldStep &f, const Surface &surface) {
    const float s = f.seen[0] + (f.unseen[0] + f.bend[0] * f.fraction) * f.fraction;
    const float t = f.seen[1] + (f.unseen[1] + f.bend[1] * f.fraction) * f.fraction;
    return make_float2(clamp(s, surface.domain[0]), clamp(t, surface.domain[1]));
}

// The next trial after one that left the residual (rx, ry); without `solve` just shorter.
static __device__ __forceinline__ void shorten(FoldStep &f, float rx, float ry, bool solve) {
    const float by_square = 1.0f / (f.fraction * f.fraction);
    // Along the image nothing should be left; across it, what the fraction leaves of the linear part.
    const float along = (f.image[0] * rx + f.image[1] * ry) * by_square /
                        (f.image[0] * f.image[0] + f.image[1] * f.image[1] + TINY);
    const float curvature =
        (f.across * (1.0f - f.linear * f.fraction) - (f.image[0] * ry - f.image[1] * rx)) * by_square;
    // across (1 - linear f) = curvature f^2; without a solution, the nearest that there is: the fold.
    const float inside = f.across * (f.across * f.linear + curvature * 4.0f);
    const float root =
        f.across * 2.0f / (f.across * f.linear + copysignf(sqrtf(larger(inside, 0.0f)), f.across));
    const float solution = inside >= 0.0f ? root : f.across * f.linear / (curvature * -2.0f);
    // Also where there is no number to be had.
    const float best = solution >= f.fraction * 0.02f ? solution : f.fraction * 0.25f;
    f.fraction = solve ? smaller(smaller(best, f.fraction * 1.5f), f.limit) : f.fraction * 0.25f;
    f.bend[0] = f.bend[0] + f.v[0] * along;
    f.bend[1] = f.bend[1] + f.v[1] * along;
}

} // namespace refinement
