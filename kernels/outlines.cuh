// A meshlet's fragments for the spare buffer, by one warp: strokes along its borders and folds, or ETER's conservative
// fragments. Twin of `outlines` in src/stages/rasterize.rs.
#pragma once
#include "stroke.cuh"

namespace outlines {

constexpr unsigned ALL = 0xffffffffu;
// Boxes of more pixels are shared by the warp.
constexpr i64 LARGE = 256;

// Calls draw(k, first, step) for all items k below `count`: small ones by a lane alone (0, 1), large ones by all lanes
// together (lane, 32). `pixels(k)` is how many pixels an item may touch.
template <class Pixels, class Draw>
static __device__ __forceinline__ void for_all(int count, int lane, Pixels pixels, Draw draw) {
    for (int first = 0; first < count; first += 32) {
        int k = first + lane, start = 0, step = 1;
        const i64 size = k < count ? pixels(k) : 0;
        unsigned large = __ballot_sync(ALL, size > LARGE);
        bool draws = size > 0 && size <= LARGE;
        // One call for both, so that its code is there once.
        while (true) {
            if (draws) {
                draw(k, start, step);
            }
            if (large == 0) {
                break;
            }
            k = first + __ffs(large) - 1;
            large &= large - 1;
            start = lane;
            step = 32;
            draws = true;
        }
    }
}

static __device__ __forceinline__ i64 pixels_of(const PixelBox &box) { return box.empty() ? 0 : box.pixels(); }

// What all strokes of a meshlet have in common.
struct Drawn {
    const View &view;
    const Geometry &in;
    const Meshlet &m;
    const Patch &patch;
    const Leaf &leaf;
    uint32_t number;

    __device__ Word id(uint32_t index) const { return topology::word(0.0f, number, index); }
    __device__ Corners corners(const topology::Primitive &p) const { return topology::corners(in, m, p); }
};

template <class Found> static __device__ __forceinline__ void conservative(const Drawn &d, int lane, Found found) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    for_all(
        topology::triangles(d.m), lane,
        [&](int k) {
            PixelBox box = Coverage::box_of(d.view, corners(k));
            // Half a pixel more on all sides.
            return (box.x.high - box.x.low + 3) * (box.y.high - box.y.low + 3);
        },
        [&](int k, int first, int step) { stroke::conservative(d.view, corners(k), d.id(k), first, step, found); });
}

template <class Found> static __device__ __forceinline__ void borders(const Drawn &d, int lane, Found found) {
    constexpr int A_SIDE = int(EDGES_A_SIDE);
    const auto edge = [&](int k) { return d.corners(topology::edge(d.m, d.patch.diagonal, k / A_SIDE, k % A_SIDE)); };
    for_all(
        4 * A_SIDE, lane,
        [&](int k) {
            const int side = k / A_SIDE;
            if ((d.m.outer >> side & 1) == 0 || k % A_SIDE >= topology::edges(d.m, side)) {
                return i64(0);
            }
            const Corners corners = edge(k);
            // Edges of sides u = 0 and v = 1 come against the parameters' order.
            const int hidden = side == 0 || side == 3 ? -d.patch.hidden : d.patch.hidden;
            // The surface behind an edge that may fold is seen from both sides.
            if (faces_away(corners, hidden) && !stroke::may_fold(d.leaf, corners)) {
                return i64(0);
            }
            const i64 radius = max(d.leaf.pen_radius, d.leaf.pen_sides[side]);
            return pixels_of(stroke::Segment::between(corners.v[0], corners.v[1], radius).box(d.view));
        },
        [&](int k, int first, int step) {
            const int side = k / A_SIDE;
            const Word id = d.id(topology::edge_index(side, k % A_SIDE));
            stroke::border(d.view, d.leaf, edge(k), side, id, first, step, found);
        });
}

// The meshlets of the same patch that follow one in u and in v. They come in parameter order, v innermost.
struct Next {
    uint32_t u, v;
    bool has_u, has_v;
};

static __device__ __forceinline__ Next next_of(const Drawn &d, uint32_t count) {
    const int end_u = d.m.first[0] + d.m.quads[0], end_v = d.m.first[1] + d.m.quads[1];
    Next next = {0, d.number + 1, false, false};
    if (next.v < count && (d.m.outer >> 3 & 1) == 0) {
        const Meshlet m = d.in.meshlets[next.v];
        next.has_v = m.patch == d.m.patch && m.first[0] == d.m.first[0] && m.first[1] == end_v;
    }
    if ((d.m.outer >> 1 & 1) == 0) {
        for (next.u = d.number + 1; next.u < count && !next.has_u; next.u += !next.has_u) {
            const Meshlet m = d.in.meshlets[next.u];
            if (m.patch != d.m.patch) {
                break;
            }
            next.has_u = m.first[0] == end_u && m.first[1] == d.m.first[1];
        }
    }
    return next;
}

static __device__ __forceinline__ int facing(const Drawn &d, const Meshlet &m, int a, int b, int second) {
    return sign(area_of(topology::corners(d.in, m, topology::triangle(a, b, d.patch.diagonal, second))));
}

// Two ends of an edge between triangles that face different ways; `across` tells whether it is one.
struct FoldEdge {
    topology::Corner from, to;
    bool across;
};

// Of quad (a, b): kind 0 its diagonal, 1 its side towards the next v, 2 the one towards the next u.
static __device__ __forceinline__ FoldEdge fold_edge(const Drawn &d, const Next &next, int k) {
    const int kind = k % 3, a = k / 3 / d.m.quads[1], b = k / 3 % d.m.quads[1];
    const bool main = d.patch.diagonal == 0;
    if (kind == 0) {
        const bool across = facing(d, d.m, a, b, 0) != facing(d, d.m, a, b, 1);
        return main ? FoldEdge{{a, b}, {a + 1, b + 1}, across} : FoldEdge{{a + 1, b}, {a, b + 1}, across};
    }
    if (kind == 1) {
        // The triangle on side v = 1 is always the second, on v = 0 the first.
        FoldEdge edge = {{a, b + 1}, {a + 1, b + 1}, false};
        if (b + 1 < d.m.quads[1]) {
            edge.across = facing(d, d.m, a, b, 1) != facing(d, d.m, a, b + 1, 0);
        } else if (next.has_v) {
            edge.across = facing(d, d.m, a, b, 1) != facing(d, d.in.meshlets[next.v], a, 0, 0);
        }
        return edge;
    }
    // Those on u = 1 and u = 0 go by the diagonal.
    FoldEdge edge = {{a + 1, b}, {a + 1, b + 1}, false};
    if (a + 1 < d.m.quads[0]) {
        edge.across = facing(d, d.m, a, b, main ? 0 : 1) != facing(d, d.m, a + 1, b, main ? 1 : 0);
    } else if (next.has_u) {
        edge.across = facing(d, d.m, a, b, main ? 0 : 1) != facing(d, d.in.meshlets[next.u], 0, b, main ? 1 : 0);
    }
    return edge;
}

// Strokes along the grid's silhouette: edges between a triangle that faces the eye and one that does not.
template <class Found> static __device__ __forceinline__ void folds(const Drawn &d, uint32_t count, int lane, Found found) {
    const Next next = next_of(d, count);
    const auto vertex = [&](topology::Corner c) { return topology::vertex(d.in, d.m, c); };
    for_all(
        3 * d.m.quads[0] * d.m.quads[1], lane,
        [&](int k) {
            const FoldEdge edge = fold_edge(d, next, k);
            if (!edge.across) {
                return i64(0);
            }
            return pixels_of(stroke::Segment::between(vertex(edge.from), vertex(edge.to), d.leaf.pen_fold).box(d.view));
        },
        [&](int k, int first, int step) {
            const FoldEdge edge = fold_edge(d, next, k);
            stroke::fold(d.view, d.leaf, vertex(edge.from), vertex(edge.to), d.id(FOLD_INDEX), first, step, found);
        });
}

// Triangles that show the inside of a solid, where the surface may fold and show its outside.
template <class Found> static __device__ __forceinline__ void turned_away(const Drawn &d, int lane, Found found) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    for_all(
        topology::triangles(d.m), lane,
        [&](int k) {
            const Corners c = corners(k);
            return faces_away(c, d.patch.hidden) && stroke::may_fold(d.leaf, c) ? pixels_of(Coverage::box_of(d.view, c)) : 0;
        },
        [&](int k, int first, int step) {
            const Corners c = corners(k);
            Coverage::of(c, Coverage::box_of(d.view, c)).each(d.id(FOLD_INDEX), first, step, found);
        });
}

// All of them: calls found(x, y, word). `count`: of all meshlets.
template <class Found> static __device__ __forceinline__ void draw(const Drawn &d, uint32_t count, int lane, Found found) {
    if (d.view.fill == FILL_ETER || d.view.fill == FILL_CONSERVATIVE) {
        conservative(d, lane, found);
    }
    if (d.view.fill != FILL_STROKE) {
        return;
    }
    if (d.leaf.pen_fold > 0) {
        folds(d, count, lane, found);
        if (d.patch.hidden != 0) {
            turned_away(d, lane, found);
        }
    }
    borders(d, lane, found);
}

} // namespace outlines
