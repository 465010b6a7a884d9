// Which arithmetic a patch is evaluated in: an a-priori bound of each one's error, and the cheapest that fits. Twin of
// src/cuda/precision.rs, where everything is derived, and src/cuda/selection.rs.
#pragma once
#include "abi.h"
#include "compat.cuh"

namespace precision {

constexpr double U = 1.0 / 16777216.0;
constexpr double P = 1.0 / 2048.0;
constexpr int LARGEST_TENSOR_DEGREE = 7;
constexpr double NAMED_SHARE = 1.0 / 4.0;
constexpr double CHOSEN_SHARE = 1.0 / 32.0;
constexpr uint32_t LARGE_BLOCK = 32;

// What a bound needs to know of a patch.
struct Hull {
    int degree_u, degree_v;
    double reach, range, cancellation, relief;

    // Of a degree that tensor cores do.
    __device__ __forceinline__ bool is_small() const {
        return min(degree_u, degree_v) >= 1 && max(degree_u, degree_v) <= LARGEST_TENSOR_DEGREE;
    }
};

// What a vertex may be off by: pixels, stored depth, relative the weight.
struct Bound {
    double place, depth, weight;
};

// What a patch is evaluated in, with the pixels, and pixel sizes of depth, that this takes.
struct Chosen {
    uint32_t arithmetic;
    double pixels, depth;
};

static __device__ __forceinline__ Hull hull_of(const View &view, int degree_u, int degree_v, double reach, double range,
                                               double nearest, double origin, double relief) {
    if (view.perspective) {
        return {degree_u, degree_v, reach, range, (origin + relief) / nearest, relief / nearest};
    }
    return {degree_u, degree_v, reach, range, 1.0, relief * double(view.depth_slope)};
}

static __device__ __forceinline__ double grown(double errors) { return errors * (1.0 + errors); }

// Relative error of a quotient whose divisor errs by `e`.
static __device__ __forceinline__ double quotient(double e) { return e < 1.0 ? e / (1.0 - e) : INFINITY; }

// Error of a mean of numbers up to 1.
static __device__ __forceinline__ double mean_error(double shared, double own, double cancellation) {
    const double a = min(own * cancellation / (2.0 * shared), 1.0);
    const double first_order = shared * (1.0 - a * a) + own * (1.0 + cancellation * a);
    const double higher = 1.0 - 2.0 * cancellation * (shared + own);
    return higher > 0.0 ? first_order / higher : INFINITY;
}

static __device__ inline Bound bound_of(uint32_t arithmetic, const Hull &hull) {
    const double degrees = double(hull.degree_u) + double(hull.degree_v);
    double shared, relative, vanishing = 0.0;
    if (arithmetic == ARITHMETIC_F32) {
        shared = grown(2.0 * U);
        relative = grown((degrees + 6.0) * U);
    } else if (arithmetic == ARITHMETIC_F16_RECOVERED || arithmetic == ARITHMETIC_TF32_RECOVERED) {
        shared = grown(6.0 * U);
        relative = grown((degrees + 25.0) * U);
    } else {
        shared = grown(2.0 * U + 2.0 * P);
        relative = grown((degrees + 16.0) * U + 2.0 * P);
    }
    if (arithmetic >= ARITHMETIC_F16 && arithmetic <= ARITHMETIC_F16_SPARSE) {
        vanishing = 1.0 / 1073741824.0 + (degrees + 2.0) * (1.0 / 17179869184.0) + 1.0 / 274877906944.0;
    }
    const double own = relative + vanishing * hull.range;
    const double own_depth = relative + vanishing * hull.range * hull.cancellation;
    const double relief = hull.relief * mean_error(shared, own_depth, 1.0);
    return {hull.reach * mean_error(shared, own, hull.cancellation),
            quotient(relief) + (4.0 + 2.0 * hull.cancellation) * U, quotient(shared + own * hull.cancellation)};
}

static __device__ inline Chosen taken(const View &view, const Hull &hull, uint32_t arithmetic, const Bound &single) {
    const Bound bound = bound_of(arithmetic, hull);
    const double weight = view.projective ? bound.weight : view.perspective ? bound.depth : 0.0;
    const double pixels = bound.place + hull.reach * quotient(weight);
    const double depth = max(bound.depth - single.depth, 0.0);
    return {arithmetic, pixels, depth * view.scale * (view.perspective ? 1.0 : view.extent)};
}

static __device__ __forceinline__ bool fits(const View &view, const Chosen &chosen, double share) {
    return chosen.pixels <= view.tolerance * share && chosen.depth <= view.depth_tolerance * share;
}

// False: the one asked for takes too much of the tolerances, unless the patch is halved.
static __device__ inline bool choose(const View &view, const Rules &rules, const Hull &hull, Chosen &best) {
    const Bound single = bound_of(ARITHMETIC_F32, hull);
    best = taken(view, hull, ARITHMETIC_F32, single);
    if (rules.precision == ARITHMETIC_F32 || !hull.is_small()) {
        return true;
    }
    if (rules.precision != PRECISION_AUTO) {
        best = taken(view, hull, rules.precision, single);
        return fits(view, best, NAMED_SHARE);
    }
    double clocks = rules.f32_clocks[max(hull.degree_u, hull.degree_v) - 1];
    for (uint32_t arithmetic = ARITHMETIC_F32 + 1; arithmetic < ARITHMETICS; arithmetic++) {
        if (rules.clocks[arithmetic] < clocks) {
            const Chosen other = taken(view, hull, arithmetic, single);
            if (fits(view, other, CHOSEN_SHARE)) {
                best = other;
                clocks = rules.clocks[arithmetic];
            }
        }
    }
    return true;
}

// What a leaf with this grid is evaluated in: `Selection::of_grid`.
static __device__ inline uint32_t of_grid(const Rules &rules, uint32_t arithmetic, const uint32_t (&quads)[2]) {
    const uint32_t most = MESHLET_VERTICES - 1;
    uint32_t lines[2];
#pragma unroll
    for (int k = 0; k < 2; k++) {
        const uint32_t blocks = (quads[k] + most - 1) / most;
        lines[k] = (quads[k] + blocks - 1) / blocks + 1;
    }
    return rules.large_blocks && lines[0] * lines[1] < LARGE_BLOCK ? uint32_t(ARITHMETIC_F32) : arithmetic;
}

} // namespace precision
