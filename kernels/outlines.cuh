// A meshlet's fragments for the spare buffer, by a group of lanes: strokes along its borders and folds, or ETER's conservative
// fragments. Twin of `outlines` in src/stages/rasterize.rs.
#pragma once
#include "stroke.cuh"

namespace outlines {

// Boxes of more pixels are shared by all lanes of a meshlet.
constexpr i64 LARGE = 256;

// The lanes that draw one meshlet together: a part of a warp.
template <int LANES> struct Group {
    int lane;
    unsigned mask;

    static __device__ __forceinline__ Group here() {
        const int lane = threadIdx.x % LANES, first = threadIdx.x % 32 - lane;
        return {lane, (LANES == 32 ? ~0u : (1u << LANES) - 1) << first};
    }

    __device__ __forceinline__ void sync() const {
        if (LANES > 1) {
            __syncwarp(mask);
        }
    }

    // Of each lane's answer a bit, the first lane's lowest.
    __device__ __forceinline__ unsigned ballot(bool holds) const {
        return LANES == 1 ? holds : __ballot_sync(mask, holds) >> (__ffs(mask) - 1);
    }
};

// Calls draw(k, first, step) for all items k below `count`: small ones by a lane alone (0, 1), large ones by all lanes
// together (lane, LANES). `pixels(k)` is how many pixels an item may touch.
template <int LANES, class Pixels, class Draw>
static __device__ __forceinline__ void for_all(const Group<LANES> &group, int count, Pixels pixels, Draw draw) {
    for (int first = 0; first < count; first += LANES) {
        int k = first + group.lane, start = 0, step = 1;
        const i64 size = k < count ? pixels(k) : 0;
        unsigned large = group.ballot(size > LARGE);
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
            start = group.lane;
            step = LANES;
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
    // Its vertices, by all that draw it.
    Span<const Vertex> tile;

    __device__ Word id(uint32_t index) const { return topology::word(0.0f, number, index); }
    __device__ Vertex vertex(topology::Corner c) const { return tile[c.i * (m.quads[1] + 1) + c.j]; }
    __device__ Corners corners(const topology::Primitive &p) const {
        return {{vertex(p.corner[0]), vertex(p.corner[1]), vertex(p.corner[2])}};
    }
};

// Brings a meshlet's vertices together: from memory, or evaluated.
template <int LANES>
static __device__ __forceinline__ void load(const Group<LANES> &group, const Geometry &in, const Meshlet &m, Span<Vertex> tile) {
    const int across = m.quads[1] + 1, count = (m.quads[0] + 1) * across;
    for (int k = group.lane; k < count; k += LANES) {
        tile[k] = topology::load(in, m, {k / across, k % across});
    }
    group.sync();
}

template <int LANES, class Found>
static __device__ __forceinline__ void conservative(const Group<LANES> &group, const Drawn &d, Found found) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    for_all(
        group, topology::triangles(d.m),
        [&](int k) {
            PixelBox box = coverage::box_of(d.view, corners(k));
            // Half a pixel more on all sides.
            return (box.x.high - box.x.low + 3) * (box.y.high - box.y.low + 3);
        },
        [&](int k, int first, int step) { stroke::conservative(d.view, corners(k), d.id(k), first, step, found); });
}

template <int LANES, class Found>
static __device__ __forceinline__ void borders(const Group<LANES> &group, const Drawn &d, Found found) {
    constexpr int A_SIDE = int(EDGES_A_SIDE);
    const auto edge = [&](int k) { return d.corners(topology::edge(d.m, d.patch.diagonal, k / A_SIDE, k % A_SIDE)); };
    for_all(
        group, 4 * A_SIDE,
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
    static constexpr uint32_t NONE = ~0u;
    uint32_t u, v;
};

static __device__ __forceinline__ Next next_of(const Drawn &d, uint32_t count) {
    const int end_u = d.m.first[0] + d.m.quads[0], end_v = d.m.first[1] + d.m.quads[1];
    Next next = {Next::NONE, Next::NONE};
    const bool inner_u = (d.m.outer >> 1 & 1) == 0, inner_v = (d.m.outer >> 3 & 1) == 0;
    // The one in v is the very next.
    for (uint32_t k = d.number + 1; k < count && (inner_u || k == d.number + 1) && next.u == Next::NONE; k++) {
        const Meshlet &m = d.in.meshlets[k];
        if (m.patch != d.m.patch) {
            break;
        }
        if (inner_v && k == d.number + 1 && m.first[0] == d.m.first[0] && m.first[1] == end_v) {
            next.v = k;
        }
        if (inner_u && m.first[0] == end_u && m.first[1] == d.m.first[1]) {
            next.u = k;
        }
    }
    return next;
}

// Sense of rotation of a triangle of quad (a, b), in parameter order.
static __device__ __forceinline__ int facing(const Drawn &d, int a, int b, int second) {
    return sign(area_of(d.corners(topology::triangle(a, b, d.patch.diagonal, second))));
}

// The same in another meshlet of the patch.
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
        const bool across = facing(d, a, b, 0) != facing(d, a, b, 1);
        return main ? FoldEdge{{a, b}, {a + 1, b + 1}, across} : FoldEdge{{a + 1, b}, {a, b + 1}, across};
    }
    if (kind == 1) {
        // The triangle on side v = 1 is always the second, on v = 0 the first.
        FoldEdge edge = {{a, b + 1}, {a + 1, b + 1}, false};
        if (b + 1 < d.m.quads[1]) {
            edge.across = facing(d, a, b, 1) != facing(d, a, b + 1, 0);
        } else if (next.v != Next::NONE) {
            edge.across = facing(d, a, b, 1) != facing(d, d.in.meshlets[next.v], a, 0, 0);
        }
        return edge;
    }
    // Those on u = 1 and u = 0 go by the diagonal.
    FoldEdge edge = {{a + 1, b}, {a + 1, b + 1}, false};
    if (a + 1 < d.m.quads[0]) {
        edge.across = facing(d, a, b, main ? 0 : 1) != facing(d, a + 1, b, main ? 1 : 0);
    } else if (next.u != Next::NONE) {
        edge.across = facing(d, a, b, main ? 0 : 1) != facing(d, d.in.meshlets[next.u], 0, b, main ? 1 : 0);
    }
    return edge;
}

// Strokes along the grid's silhouette: edges between a triangle that faces the eye and one that does not.
template <int LANES, class Found>
static __device__ __forceinline__ void folds(const Group<LANES> &group, const Drawn &d, uint32_t count, Found found) {
    const Next next = next_of(d, count);
    const auto vertex = [&](topology::Corner c) { return d.vertex(c); };
    for_all(
        group, 3 * d.m.quads[0] * d.m.quads[1],
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
template <int LANES, class Found>
static __device__ __forceinline__ void turned_away(const Group<LANES> &group, const Drawn &d, Found found) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    for_all(
        group, topology::triangles(d.m),
        [&](int k) {
            const Corners c = corners(k);
            return faces_away(c, d.patch.hidden) && stroke::may_fold(d.leaf, c) ? pixels_of(coverage::box_of(d.view, c)) : 0;
        },
        [&](int k, int first, int step) {
            const Corners c = corners(k);
            coverage::each(d.view, c, d.id(FOLD_INDEX), first, step, found);
        });
}

// All of them: calls found(x, y, word). `count`: of all meshlets.
template <int LANES, class Found>
static __device__ __forceinline__ void draw(const Group<LANES> &group, const Drawn &d, uint32_t count, Found found) {
    if (d.view.fill == FILL_ETER || d.view.fill == FILL_CONSERVATIVE) {
        conservative(group, d, found);
    }
    if (d.view.fill != FILL_STROKE) {
        return;
    }
    if (d.leaf.pen_fold > 0) {
        folds(group, d, count, found);
        if (d.patch.hidden != 0) {
            turned_away(group, d, found);
        }
    }
    borders(group, d, found);
}

} // namespace outlines
