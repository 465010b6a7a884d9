// The grid of a leaf from its bound. Twin of src/stages/estimate.rs, where everything is explained.
#pragma once
#include "slefe.cuh"

namespace estimate {

constexpr double SNAPPING = 1.0 / 512.0;
constexpr uint32_t MESHLET = MESHLET_VERTICES - 1;
constexpr uint32_t MAX_SIDE = 1 << 12;
constexpr uint32_t MAX_QUADS = 1 << 14;
constexpr double HALVES_KEPT = 0.875;
constexpr uint32_t LOOK_AHEAD = 1;
constexpr uint32_t MAX_DEPTH = 40;

struct Grid {
    uint32_t quads[2];
    uint32_t diagonal;
    // Pixels, and camera depth in model units.
    float deviation[2];

    __device__ __forceinline__ uint32_t all_quads() const { return quads[0] * quads[1]; }

    // Vertices of its meshlets; neighbours repeat their common ones.
    __device__ __forceinline__ uint64_t vertices() const {
        const uint64_t u = quads[0] + (quads[0] + MESHLET - 1) / MESHLET;
        return u * (quads[1] + (quads[1] + MESHLET - 1) / MESHLET);
    }
};

enum Outcome {
    GRID,
    // Too large: to be split across u, or across v.
    SPLIT_U,
    SPLIT_V,
    // Errors.
    TOO_LARGE,
    NO_TOLERANCE,
};

// The smallest nv for a given nu.
static __device__ __forceinline__ double fewest_across(const bounds::Constraints &constraints, int diagonal, double nu) {
    double nv = 1.0;
    for (int k = 0; k < constraints.count; k++) {
        const bounds::Constraint q = constraints.at(k);
        const double s = 1.0 - q.a / (nu * nu);
        const double b = (diagonal ? q.b[1] : q.b[0]) / nu;
        if (s > 0.0) {
            if ((s * nv - b) * nv < q.c) {
                nv = max(nv, (b + sqrt(b * b + 4.0 * s * q.c)) / (2.0 * s));
            }
        } else if (b > 0.0 || q.c > 0.0 || s < 0.0) {
            return INFINITY;
        }
    }
    return ceil(nv * (1.0 - 1e-12));
}

// The fewest quads that satisfy all constraints of one diagonal; false above MAX_SIDE.
static __device__ __forceinline__ bool solve_one(const bounds::Constraints &constraints, int diagonal, uint32_t (&quads)[2]) {
    bool one = true;
    double most_a = 0.0, most_c = 0.0;
    for (int k = 0; k < constraints.count; k++) {
        const bounds::Constraint q = constraints.at(k);
        one = one && q.a + (diagonal ? q.b[1] : q.b[0]) + q.c <= 1.0;
        most_a = max(most_a, q.a), most_c = max(most_c, q.c);
    }
    quads[0] = quads[1] = 1;
    if (one) {
        return true;
    }
    double nu = max(ceil(sqrt(most_a)), 1.0);
    const double floor = max(ceil(sqrt(most_c)), 1.0), side = double(MAX_SIDE);
    if (!(nu <= side && floor <= side)) {
        return false;
    }
    double area = INFINITY;
    for (; nu <= side && nu * floor < area; nu += 1.0) {
        const double nv = fewest_across(constraints, diagonal, nu);
        if (nv * nu < area && nv <= side) {
            quads[0] = uint32_t(nu), quads[1] = uint32_t(nv);
            area = nu * nv;
        }
    }
    return area < INFINITY;
}

// The better of both diagonals.
static __device__ __forceinline__ bool solve(const bounds::Constraints &constraints, Grid &grid) {
    bool solved = false;
#pragma unroll 1
    for (int diagonal = 0; diagonal < 2; diagonal++) {
        uint32_t quads[2];
        const bool here = solve_one(constraints, diagonal, quads);
        if (here && (!solved || quads[0] * quads[1] < grid.all_quads())) {
            grid.quads[0] = quads[0], grid.quads[1] = quads[1];
            grid.diagonal = uint32_t(diagonal);
            solved = true;
        }
    }
    return solved;
}

template <int LANES>
static __device__ __forceinline__ void constrain(const Team<LANES> &team, uint32_t bound, const bounds::Subject &s,
                                 const bounds::Enclosure &enclosure, bounds::Constraints &out) {
    if (bound == BOUND_SCREEN) {
        bounds::screen(s, enclosure, out);
    } else if (bound == BOUND_FILIP) {
        bounds::filip(team, s, enclosure, out);
    } else if (bound == BOUND_ETER) {
        const double epsilon = bounds::isotropic_epsilon(team, s);
        bounds::eter_within(team, s, epsilon, epsilon, [&](const bounds::Constraint &q) { out.push(q); });
    } else if (bound == BOUND_PROJECTIVE) {
        bounds::projective(team, s, out);
    } else {
        const double pieces = slefe::pieces(team, s);
        out.push({pieces, {0.0, 0.0}, 0.0});
        out.push({0.0, {0.0, 0.0}, pieces});
    }
    team.sync();
}

// What a grid is off by at most: pixels and camera depth. False: the bound says no more than that the tolerances are kept.
template <int LANES>
static __device__ __forceinline__ bool deviation(const Team<LANES> &team, uint32_t bound, const bounds::Subject &s,
                                 const bounds::Enclosure &enclosure, const bounds::Constraints &used, const Grid &grid,
                                 double &pixels, double &depth) {
    const int diagonal = int(grid.diagonal);
    const double nu = grid.quads[0], nv = grid.quads[1];
    pixels = 0.0, depth = 0.0;
    if (bound == BOUND_SCREEN && !used.narrow) {
        for (int k = 0; k < used.count; k++) {
            const double share = used.at(k).share(diagonal, nu, nv);
            pixels = k < used.depth ? max(pixels, share) : pixels;
            depth = k < used.depth ? depth : max(depth, share);
        }
        depth = depth * s.depth_tolerance;
        const double tilt = s.view.perspective ? depth / s.place.low.z : 0.0;
        pixels = (pixels + tilt) * s.tolerance;
        return true;
    }
    if (bound == BOUND_SCREEN || bound == BOUND_FILIP) {
        bounds::affine_deviation(s, enclosure, diagonal, nu, nv, pixels, depth);
        return true;
    }
    if (bound == BOUND_ETER) {
        double share = 0.0;
        bounds::eter_within(team, s, bounds::isotropic_epsilon(team, s), 0.0,
                            [&](const bounds::Constraint &q) { share = max(share, q.share(diagonal, nu, nv)); });
        pixels = share * s.tolerance;
        depth = share * s.depth_tolerance;
        return true;
    }
    return false;
}

// The next larger number in f32, of one that is not negative.
static __device__ __forceinline__ float next_up(double value) { return __uint_as_float(__float_as_uint(float(value)) + 1); }

// Splits across what is worse along u and v.
static __device__ __forceinline__ Outcome split_along(uint32_t depth, double u, double v) {
    return depth >= MAX_DEPTH ? TOO_LARGE : v > u ? SPLIT_V : SPLIT_U;
}

static __device__ __forceinline__ Outcome too_large(const bounds::Constraints &constraints, uint32_t depth) {
    double u = 0.0, v = 0.0;
    for (int k = 0; k < constraints.count; k++) {
        u = max(u, constraints.at(k).a);
        v = max(v, constraints.at(k).c);
    }
    return split_along(depth, u, v);
}

// The leaf's grid by a bound, or the axis to split where it would be too large. `small`: no triangle may be larger
// than 16 x 16 pixels. `numbers`: room for a list of constraints, `stride` apart.
template <int LANES>
static __device__ __forceinline__ Outcome grid_of(const Team<LANES> &team, const View &view, const Rules &rules,
                                                  uint32_t bound, bool small, const lens::PatchMap &map, const lens::Net &net,
                                                  const bounds::Enclosure &enclosure, const cull::Place &place,
                                                  uint32_t depth, Span<double> numbers, int stride, Grid &grid) {
    const double tolerance = view.tolerance - SNAPPING - place.evaluation[0];
    if (tolerance <= 0.0) {
        return NO_TOLERANCE;
    }
    const double depth_tolerance =
        view.depth_tolerance * lens::pixel_size(view, place.low.z) - place.evaluation[1];
    const bounds::Subject subject = {view, map, net, place, tolerance, depth_tolerance};
    // What was read of an earlier list has been read.
    team.sync();
    bounds::Constraints constraints = {numbers, stride, team.lane == 0};
    constrain(team, bound, subject, enclosure, constraints);
    if (!solve(constraints, grid)) {
        return too_large(constraints, depth);
    }
    grid.deviation[0] = float(view.tolerance);
    grid.deviation[1] = float(depth_tolerance + place.evaluation[1]);
    if (small) {
        double least[2];
        bounds::small_triangles(team, subject, least);
        if (!(max(least[0], least[1]) <= double(MAX_SIDE))) {
            return split_along(depth, least[0], least[1]);
        }
        grid.quads[0] = max(grid.quads[0], uint32_t(least[0])), grid.quads[1] = max(grid.quads[1], uint32_t(least[1]));
    }
    if (rules.grid == GRID_ETER || rules.grid == GRID_ETER16) {
        grid.quads[0] = (grid.quads[0] + MESHLET - 1) / MESHLET * MESHLET;
        grid.quads[1] = (grid.quads[1] + MESHLET - 1) / MESHLET * MESHLET;
    }
    if (grid.all_quads() > MAX_QUADS) {
        return small ? split_along(depth, grid.quads[0], grid.quads[1]) : too_large(constraints, depth);
    }
    double pixels, off;
    if (deviation(team, bound, subject, enclosure, constraints, grid, pixels, off)) {
        grid.deviation[0] = next_up(SNAPPING + place.evaluation[0] + (pixels < tolerance ? pixels : tolerance));
        grid.deviation[1] = next_up(place.evaluation[1] + (off < depth_tolerance ? off : depth_tolerance));
    }
    return GRID;
}

// Quads from which on a leaf's halves are tried.
static __device__ __forceinline__ uint32_t worth_halving(uint32_t points, bool rational) {
    return rational ? 12 * points * points : 16 * points;
}

} // namespace estimate
