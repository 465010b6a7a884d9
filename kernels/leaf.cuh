// What the stages that draw a leaf know of it. Twin of src/cuda/leaves.rs, `Pen` and `sags` in src/stages/stroke.rs, `gaps` in
// src/stages/trim_cut.rs.
#pragma once
#include "estimate.cuh"

namespace leaf {

constexpr double MAX_GAP = 0.5;
constexpr double EXTRAPOLATED = 1.0 / 128.0;

// A leaf with all that decides what is written of it.
struct Drawn {
    const View &view;
    const Rules &rules;
    const scene::Scene &scene;
    const SceneInstance &instance;
    const ScenePatch &source;
    const lens::PatchMap &map;
    const cull::Place &place;
    const estimate::Grid &grid;
    uint32_t instance_number, source_number;
    double corner[2], extent[2];
};

// The control points as they are drawn: centred in f64, then rounded. A team together.
template <int LANES>
static __device__ void write_net(const Team<LANES> &team, const Drawn &d, const lens::Net &net, Buffer<Point> out) {
    for (int k = team.lane; k < net.count(); k += LANES) {
        const Vec4 p = lens::apply(d.map, net.at(k));
        const double by = lens::denominator(d.view, p);
        out[k] = {float(p.x - d.place.center[0] * by), float(p.y - d.place.center[1] * by),
                  float(p.z - d.place.depth_origin * p.w), float(p.w)};
    }
    team.sync();
}

static __device__ double pixels_per_unit(const Drawn &d) {
    const double x = length(d.map.axes[0]), y = length(d.map.axes[1]), z = length(d.map.axes[2]);
    const double across = max(x, y) * d.view.scale;
    if (!d.view.perspective) {
        return across;
    }
    const Vec3 low = d.place.low, high = d.place.high;
    const double aside = max(max(fabs(low.x), fabs(low.y)), max(fabs(high.x), fabs(high.y)));
    return (across + aside * z) / low.z;
}

struct Place2 {
    double x, y;
};

// Squared distance of a point from the straight line between two others.
static __device__ double distance2(Place2 p, Place2 a, Place2 b) {
    const Place2 way = {b.x - a.x, b.y - a.y};
    const double along = (p.x - a.x) * way.x + (p.y - a.y) * way.y;
    const double share = clamped(along / (way.x * way.x + way.y * way.y), 0.0, 1.0);
    const Place2 q = share == share ? Place2{a.x + way.x * share, a.y + way.y * share} : a;
    return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y);
}

// How far a border of the leaf is from the straight line between its ends, at most.
static __device__ double sag(const Drawn &d, Buffer<const Point> net, int side) {
    const int m = d.source.degree[0], n = d.source.degree[1];
    const int first = side == 1 ? m * (n + 1) : side == 3 ? n : 0;
    const int step = side < 2 ? 1 : n + 1, count = side < 2 ? n : m;
    const auto at = [&](int k) {
        const Point p = net[first + k * step];
        const double by = d.view.perspective ? double(p.z) + d.place.depth_origin * double(p.w) : double(p.w);
        return Place2{double(p.x) / by, double(p.y) / by};
    };
    const Place2 a = at(0), b = at(count);
    double most = 0.0;
    for (int k = 1; k < count; k++) {
        most = max(most, distance2(at(k), a, b));
    }
    return 2.0 * sqrt(most);
}

// The radius of a pen that reaches so many pixels, in sub-pixels.
static __device__ __forceinline__ int radius_of(double reach) {
    const double radius = ceil(double(SUBPIXELS) * reach + 0.5);
    return radius < 2147483647.0 ? int(radius) : radius == radius ? 2147483647 : 0;
}

// `Pen::new`; `rim`: the face ends or is cut here, `gap` is the model's own.
static __device__ void pens(const Drawn &d, bool rim, double gap, Buffer<const Point> net, Leaf &out) {
    const bool refine = d.view.refine > 0;
    const uint32_t bound = d.rules.bound;
    const bool tells = bound == BOUND_SCREEN || bound == BOUND_FILIP || bound == BOUND_ETER;
    const double rounding = d.place.evaluation[0], off = double(d.grid.deviation[0]);
    const double half = 0.5 * max(d.view.tolerance - 0.5 / double(SUBPIXELS) - rounding, 0.0) + rounding;
    gap = rim ? gap : 0.0;
    out.pen_radius = radius_of(refine && rim ? off + gap : refine && tells ? off : half);
    out.pen_fold = refine ? radius_of(off + gap) : 0;
#pragma unroll
    for (int side = 0; side < 4; side++) {
        out.pen_sides[side] = out.pen_radius;
        if (refine && (tells || rim)) {
            const double reach = min(off, sag(d, net, side) + 0.5 / double(SUBPIXELS) + rounding);
            out.pen_sides[side] = radius_of(reach + gap);
        }
    }
}

// Parameters of the leaf that lie in its patch, as far as refinement may go.
static __device__ void domain(const Drawn &d, Leaf &out) {
    const int degree = d.source.degree[0] + d.source.degree[1];
    const double beyond = max(lens::root(EXTRAPOLATED / d.place.rounding, degree) - 1.0, 0.0) * 0.5;
#pragma unroll
    for (int k = 0; k < 2; k++) {
        out.domain[k][0] = float(clamped((0.0 - d.corner[k]) / d.extent[k], -beyond, 1.0 + beyond));
        out.domain[k][1] = float(clamped((1.0 - d.corner[k]) / d.extent[k], -beyond, 1.0 + beyond));
    }
}

static __device__ Leaf leaf_of(const Drawn &d, Buffer<const Point> net) {
    const ScenePatch &source = d.source;
    const bool trims = d.view.trim != 0;
    Leaf out;
#pragma unroll
    for (int k = 0; k < 2; k++) {
        out.corner[k] = d.corner[k];
        out.extent[k] = d.extent[k];
        const double size = source.domain[k][1] - source.domain[k][0];
        out.plane_origin[k] = source.domain[k][0] + size * d.corner[k];
        out.plane_size[k] = size * d.extent[k];
        out.deviation[k] = d.grid.deviation[k];
        out.center[k] = int(d.place.center[k]);
    }
    out.pixels_per_unit = pixels_per_unit(d);
    out.rounding = d.place.rounding;
    const double own = source.tree == NO_TREE ? 0.0 : d.scene.trims.trees[source.tree].gap;
    out.gaps[0] = min(source.gap * out.pixels_per_unit, MAX_GAP);
    out.gaps[1] = min(max(own, source.gap) * out.pixels_per_unit, MAX_GAP);
    domain(d, out);
    out.depth_tolerance = float(d.view.depth_tolerance * lens::pixel_size(d.view, d.place.low.z));
    const FaceColor color = scene::color_of(d.scene, d.instance, source.face);
    out.color[0] = color.color[0], out.color[1] = color.color[1], out.color[2] = color.color[2];
    pens(d, trims && (source.tree != NO_TREE || source.rim), out.gaps[1], net, out);
    out.tree = trims ? source.tree : NO_TREE;
    out.rational = source.rational;
    out.arithmetic = uint16_t(precision::of_grid(d.rules, d.place.arithmetic, d.grid.quads));
    return out;
}

// `net`: the number of its first control point. Its tables come later.
static __device__ Patch patch_of(const Drawn &d, uint32_t net) {
    const int side = scene::visible_side(d.rules, d.source);
    Patch out = {};
    out.net = net;
#pragma unroll
    for (int k = 0; k < 2; k++) {
        out.quads[k] = uint16_t(d.grid.quads[k]);
        out.degree[k] = d.source.degree[k];
        out.base[k] = int(d.place.center[k]) * SUBPIXELS + int(d.view.size[k]) * (SUBPIXELS / 2);
    }
    out.diagonal = uint8_t(d.grid.diagonal);
    out.hidden = int8_t(lens::mirrors(d.map) ? -side : side);
    out.depth_origin = float(d.place.depth_origin);
    out.depth_offset = float(1.0 - (d.place.depth_origin - d.view.near) / d.view.extent);
    out.rounding = float(d.place.rounding);
    out.instance = d.instance_number;
    out.source = d.source_number;
    return out;
}

} // namespace leaf
