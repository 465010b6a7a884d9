// Blocks of a grid, and where they lie in the plane of their face's trims. Twin of src/stages/trim_cut.rs.
#pragma once
#include "team.cuh"
#include "trim_tree.cuh"

namespace blocks {

constexpr double MAX_GAP = 0.5;
constexpr double REFINED = 1.0 / 512.0 + 1.0 / 1024.0;
constexpr double BENT = 2.0;

// A side of a grid in the fewest blocks of at most 7 quads, as even as they go.
struct Cut {
    uint32_t quads, count, size;

    __device__ __forceinline__ uint32_t length(uint32_t block) const { return min(size, quads - block * size); }
};

static __device__ __forceinline__ Cut cut(uint32_t quads) {
    const uint32_t most = MESHLET_VERTICES - 1;
    const uint32_t count = (quads + most - 1) / most;
    return {quads, count, (quads + count - 1) / count};
}

static __device__ __forceinline__ uint32_t vertices_of(const Meshlet &m) { return (m.quads[0] + 1u) * (m.quads[1] + 1u); }

// Where a block lies whose fragments' parameters may be off by some quads.
static __device__ inline uint32_t region_of(const trims::Trims &trims, const Leaf &leaf, const Patch &patch, const Meshlet &m,
                                            double off_u, double off_v) {
    const double first_u = m.first[0], first_v = m.first[1], quads_u = patch.quads[0], quads_v = patch.quads[1];
    const auto to_plane = [&](double u, double v) {
        return trims::PlanePoint{leaf.plane_origin[0] + leaf.plane_size[0] * u, leaf.plane_origin[1] + leaf.plane_size[1] * v};
    };
    const trims::PlanePoint low = to_plane((first_u - off_u) / quads_u, (first_v - off_v) / quads_v);
    const trims::PlanePoint high = to_plane((first_u + double(m.quads[0]) + off_u) / quads_u,
                                            (first_v + double(m.quads[1]) + off_v) / quads_v);
    return trims::classify(trims, leaf.tree, trims::box_around(low, high));
}

// Pixels on its triangle that a fragment may be off by.
static __device__ inline double reach(const trims::Trims &trims, const Leaf &leaf) {
    const double margin = min(trims.trees[leaf.tree].gap * leaf.pixels_per_unit, MAX_GAP) + (REFINED + leaf.rounding);
    return (double(leaf.deviation[0]) + margin) * BENT;
}

struct Corner {
    int i, j;
};

// Enlarges u and v to the quads that the parameters of a triangle's fragments may be off by, for `reach` sub-pixels.
static __device__ inline void spread(Buffer<const Vertex> vertices, const Meshlet &m, uint32_t diagonal, uint32_t triangle,
                                     double reach, double &u, double &v) {
    const int i = int(triangle / 2) / m.quads[1], j = int(triangle / 2) % m.quads[1];
    const Corner p = {i, j}, q = {i + 1, j}, r = {i + 1, j + 1}, s = {i, j + 1};
    const bool second = triangle % 2 != 0;
    const Corner ca = second && diagonal != 0 ? q : p;
    const Corner cb = second ? r : q;
    const Corner cc = second || diagonal != 0 ? s : r;
    const auto at = [&](Corner c) { return vertices[c.i * (m.quads[1] + 1) + c.j]; };
    const Vertex a = at(ca), b = at(cb), c = at(cc);
    const double ux = double(b.x) - double(a.x), uy = double(b.y) - double(a.y);
    const double vx = double(c.x) - double(a.x), vy = double(c.y) - double(a.y);
    const double most = max(max(max(0.0, double(a.weight)), double(b.weight)), double(c.weight));
    const double least = min(min(double(a.weight), double(b.weight)), double(c.weight));
    const double ratio = most / least;
    const double inverse = ratio * ratio / fabs(ux * vy - uy * vx);
    const auto quads = [&](int first, int second) {
        return (fabs(double(first) * vy - double(second) * uy) + fabs(double(second) * ux - double(first) * vx)) * inverse
               * reach;
    };
    const double here_u = quads(cb.i - ca.i, cc.i - ca.i), here_v = quads(cb.j - ca.j, cc.j - ca.j);
    // Triangles that are edge-on have no fragments.
    if (here_u < INFINITY && here_v < INFINITY) {
        u = max(u, here_u);
        v = max(v, here_v);
    }
}

} // namespace blocks
