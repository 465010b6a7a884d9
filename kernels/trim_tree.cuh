// Trim loops as kd-trees over monotone segments: which points and boxes of the parameter plane are inside. Twin of
// src/scene/trim_tree.rs and trim_segment.rs, where everything is explained; the same operations in the same order.
#pragma once
#include "abi.h"
#include "vector.cuh"

namespace trims {

// The lists of all trees: `TrimsOnDevice` in src/cuda/trims.rs. And by leaf the textures of `--trim texture`, with their words;
// else null.
struct Trims {
    Buffer<const TrimTree> trees;
    Buffer<const TrimNode> nodes;
    Buffer<const TrimClip> clips;
    Buffer<const TrimSegment> segments;
    Buffer<const TrimPoint> points;
    Buffer<const TrimTexture> textures;
    Buffer<const uint32_t> texels;
};

struct PlanePoint {
    double u, v;
};

// A box of the parameter plane.
struct Box {
    PlanePoint low, high;

    __device__ __forceinline__ bool touches(const Box &b) const {
        return low.u <= b.high.u && b.low.u <= high.u && low.v <= b.high.v && b.low.v <= high.v;
    }
};

static __device__ __forceinline__ Box box_around(PlanePoint a, PlanePoint b) {
    return {{min(a.u, b.u), min(a.v, b.v)}, {max(a.u, b.u), max(a.v, b.v)}};
}

// A segment at work: its ends, from the lower to the upper one, and its homogeneous points.
struct Curve {
    PlanePoint a, b;
    double gap;
    Buffer<const TrimPoint> points;
    uint32_t count;

    __device__ __forceinline__ Curve(const Trims &t, uint32_t segment) {
        const TrimSegment s = t.segments[segment];
        a = {s.ends[0][0], s.ends[0][1]};
        b = {s.ends[1][0], s.ends[1][1]};
        gap = s.gap;
        points = t.points + s.first;
        count = s.count;
    }

    __device__ __forceinline__ Box bounds() const { return box_around(a, b); }
};

// The homogeneous point at t, by Horner's scheme in Bernstein form: no room for a column of points is needed.
static __device__ __forceinline__ TrimPoint homogeneous(const Curve &c, double t) {
    const double s = 1.0 - t;
    TrimPoint sum = c.points[0];
    double power = 1.0, choose = 1.0;
    const uint32_t degree = c.count - 1;
    for (uint32_t k = 1; k <= degree; k++) {
        power = power * t;
        choose = choose * double(degree + 1 - k) / double(k);
        const TrimPoint p = c.points[k];
        const double share = choose * power;
        sum = {sum.x * s + p.x * share, sum.y * s + p.y * share, sum.w * s + p.w * share};
    }
    return sum;
}

// The point at t, between the ends whatever rounding does.
static __device__ __forceinline__ PlanePoint point_at(const Curve &c, double t) {
    if (c.count == 0) {
        return {c.a.u + (c.b.u - c.a.u) * t, c.a.v + (c.b.v - c.a.v) * t};
    }
    const TrimPoint p = homogeneous(c, t);
    const Box bounds = c.bounds();
    return {clamped(p.x / p.w, bounds.low.u, bounds.high.u), clamped(p.y / p.w, bounds.low.v, bounds.high.v)};
}

// u of the straight line from a to b at height v, between theirs.
static __device__ __forceinline__ double between(PlanePoint a, PlanePoint b, double v) {
    const double width = b.v - a.v;
    const double share = width == 0.0 ? 0.5 : (v - a.v) / width;
    return clamped(a.u + (b.u - a.u) * share, min(a.u, b.u), max(a.u, b.u));
}

// Evaluations that decide a point's side.
constexpr int STEPS = 128;

// The segment passes the height of p, within its ends', where `holds(its u, p's u)` is true: a comparison.
template <class Holds> static __device__ __noinline__ bool compares(const Curve &c, PlanePoint p, Holds holds) {
    PlanePoint a = c.a, b = c.b;
    double ta = 0.0, tb = 1.0;
    for (int step = 0; step < STEPS; step++) {
        // What holds at both brackets holds between them.
        const bool here = holds(a.u, p.u);
        if (here == holds(b.u, p.u)) {
            return here;
        }
        if (c.count == 0) {
            break;
        }
        const double width = b.v - a.v;
        // Every third step halves: the others may creep.
        const bool halve = step % 3 == 2 || width <= 0.0;
        const double share = halve ? 0.5 : clamped((p.v - a.v) / width, 0.01, 0.99);
        const double t = ta + (tb - ta) * share;
        if (t == ta || t == tb) {
            break;
        }
        const PlanePoint q = point_at(c, t);
        if (q.v <= p.v) {
            ta = t;
            a = q;
        } else {
            tb = t;
            b = q;
        }
    }
    return holds(between(a, b, p.v), p.u);
}

// The place of the segment's u at height v, the end's where v is beyond one: `place` is a monotone function of u, and the segment
// is followed no farther than its place takes.
template <class Place> static __device__ inline uint32_t crossing(const Curve &c, double v, Place place) {
    PlanePoint a = c.a, b = c.b;
    if (v <= a.v) {
        return place(a.u);
    }
    if (v >= b.v) {
        return place(b.u);
    }
    double ta = 0.0, tb = 1.0;
    for (int step = 0; c.count != 0 && step < STEPS; step++) {
        const uint32_t here = place(a.u);
        if (here == place(b.u)) {
            return here;
        }
        const double width = b.v - a.v;
        // As `compares` does.
        const bool halve = step % 3 == 2 || width <= 0.0;
        const double share = halve ? 0.5 : clamped((v - a.v) / width, 0.01, 0.99);
        const double t = ta + (tb - ta) * share;
        if (t == ta || t == tb) {
            break;
        }
        const PlanePoint q = point_at(c, t);
        if (q.v <= v) {
            ta = t;
            a = q;
        } else {
            tb = t;
            b = q;
        }
    }
    return place(between(a, b, v));
}

struct Greater {
    __device__ __forceinline__ bool operator()(double a, double b) const { return a > b; }
};

struct Less {
    __device__ __forceinline__ bool operator()(double a, double b) const { return a < b; }
};

template <class Holds> static __device__ __forceinline__ bool passes(const Curve &c, PlanePoint p, Holds holds) {
    if (p.v <= c.a.v) {
        return holds(c.a.u, p.u);
    }
    return p.v >= c.b.v ? holds(c.b.u, p.u) : compares(c, p, holds);
}

// The segment has a point in the closed box: the corners across its direction lie on different sides.
static __device__ inline bool meets(const Curve &c, const Box &within) {
    if (!c.bounds().touches(within)) {
        return false;
    }
    const bool rises = c.b.u >= c.a.u;
    const PlanePoint left = {within.low.u, rises ? within.high.v : within.low.v};
    const PlanePoint right = {within.high.u, rises ? within.low.v : within.high.v};
    return !passes(c, left, Less()) && !passes(c, right, Greater());
}

// The point lies inside the loops of a tree.
inline __device__ __noinline__ bool contains(const Trims &t, uint32_t tree, PlanePoint p) {
    const TrimTree &root = t.trees[tree];
    // Also refuses what is not a number.
    if (!(root.low[0] <= p.u && p.u < root.high[0] && root.low[1] <= p.v && p.v < root.high[1])) {
        return false;
    }
    TrimNode node = t.nodes[root.root];
    while (node.tag < NODE_CELL) {
        node = t.nodes[node.first + ((node.tag ? p.v : p.u) >= node.at ? 1 : 0)];
    }
    bool inside = (node.tag & NODE_INSIDE) != 0;
    const uint32_t count = node.tag >> NODE_COUNT_SHIFT;
    for (uint32_t k = 0; k < count; k++) {
        const TrimClip clip = t.clips[node.first + k];
        const bool spans = clip.heights[0] <= p.v && p.v < clip.heights[1];
        const bool right = spans && compares(Curve(t, clip.segment), p, Greater());
        const bool below = clip.exit != EXIT_NONE && (clip.exit == EXIT_UPPER ? clip.heights[1] : clip.heights[0]) <= p.v;
        inside ^= right != below;
    }
    return inside;
}

// Calls `visit(clip)` for the clips in the cells that the closed box meets, lower cells first, until it says true; a
// segment may come several times. Without a stack: one bit a level remembers which lower halves are done, and each cell is
// found from the root (Laine, "Restart trail for stackless BVH traversal", 2010). `Builder` keeps trees below 64 levels.
template <class Visit> static __device__ bool visit(const Trims &t, uint32_t tree, const Box &within, Visit visit) {
    const TrimTree &root = t.trees[tree];
    if (!Box{{root.low[0], root.low[1]}, {root.high[0], root.high[1]}}.touches(within)) {
        return false;
    }
    uint64_t done = 0;
    while (true) {
        uint64_t waiting = 0;
        TrimNode node = t.nodes[root.root];
        for (uint64_t level = 1; node.tag < NODE_CELL; level <<= 1) {
            const bool lower = (node.tag ? within.low.v : within.low.u) <= node.at;
            const bool upper = (node.tag ? within.high.v : within.high.u) >= node.at;
            const bool up = !lower || (done & level) != 0;
            waiting |= !up && upper ? level : 0;
            node = t.nodes[node.first + (up ? 1 : 0)];
        }
        const uint32_t count = node.tag >> NODE_COUNT_SHIFT;
        for (uint32_t k = 0; k < count; k++) {
            if (visit(t.clips[node.first + k])) {
                return true;
            }
        }
        if (waiting == 0) {
            return false;
        }
        // The deepest half that waits is next; all below it starts anew.
        const uint64_t next = 1ull << (63 - __clzll((long long)waiting));
        done = (done & (next - 1)) | next;
    }
}

// Where a closed box lies: a `Region`.
inline __device__ __noinline__ uint32_t classify(const Trims &t, uint32_t tree, const Box &within) {
    if (visit(t, tree, within, [&](const TrimClip &clip) { return meets(Curve(t, clip.segment), within); })) {
        return REGION_BOUNDARY;
    }
    const PlanePoint center = {within.low.u * 0.5 + within.high.u * 0.5, within.low.v * 0.5 + within.high.v * 0.5};
    return contains(t, tree, center) ? REGION_INSIDE : REGION_OUTSIDE;
}

} // namespace trims
