// Whether a patch, or a piece of one, is drawn as it is: `Culler::judge` in src/stages/cull.rs, where everything is explained.
#pragma once
#include "precision.cuh"
#include "scene.cuh"
#include "team.cuh"

namespace cull {

constexpr double DEPTH_RATIO = 3.0;
constexpr double ROUNDING_BUDGET = 1.0 / 256.0;
constexpr double PARAMETER_BUDGET = 1.0 / 64.0;
constexpr double MARGIN = 1.0;
constexpr uint32_t MAX_DEPTH = 100;

enum Verdict { CULLED, SPLIT, TOO_CLOSE, KEEP };

// What `Leaf` of src/stages/cull.rs says of where a piece is.
struct Place {
    Vec3 low, high;
    double center[2];
    double depth_origin;
    double rounding;
    uint32_t arithmetic;
    double evaluation[2];
};

// The camera depths, and whether the whole hull lies beyond one side of the image.
template <int LANES>
static __device__ __forceinline__ Extremes depths(const Team<LANES> &team, const View &view, const lens::Net &net,
                                               const lens::PatchMap &map, bool &outside) {
    const double limit_x = lens::half_image(view, 0) + MARGIN, limit_y = lens::half_image(view, 1) + MARGIN;
    bool right = true, left = true, below = true, above = true;
    Extremes z;
    const int count = net.count();
    for (int k = team.lane; k < count; k += LANES) {
        const Vec4 p = lens::apply(map, net.at(k));
        z.add(p.z / p.w);
        const double d = lens::denominator(view, p);
        right = right && p.x > limit_x * d;
        left = left && -p.x > limit_x * d;
        below = below && p.y > limit_y * d;
        above = above && -p.y > limit_y * d;
    }
    outside = team.all(right) || team.all(left) || team.all(below) || team.all(above);
    return z.of(team);
}

// Nothing of a net that crosses the near plane is wider than half a pixel there.
template <int LANES>
static __device__ bool smaller_than_half_pixel(const Team<LANES> &team, const View &view, const lens::Net &net,
                                               const lens::PatchMap &map) {
    Extremes x, y, z;
    const int count = net.count();
    for (int k = team.lane; k < count; k += LANES) {
        const Vec4 p = lens::apply(map, net.at(k));
        x.add(p.x / p.w / view.scale);
        y.add(p.y / p.w / view.scale);
        z.add(p.z / p.w);
    }
    x = x.of(team), y = y.of(team), z = z.of(team);
    const double half = 0.5 * lens::pixel_size(view, view.near);
    return x.high - x.low < half && y.high - y.low < half && z.high - z.low < half;
}

// Bound of the error of a projected vertex in pixels, for a net `reach` pixels about its centre.
static __device__ __forceinline__ double rounding_bound(const lens::Net &net, double reach) {
    const double gamma = double(net.degree_u + net.degree_v + 8);
    return (2.0 * gamma + 2.0) * reach * (1.0 / 16777216.0);
}

// `depth` halvings made the piece. `place` is whole where it is kept.
template <int LANES>
static __device__ Verdict judge(const Team<LANES> &team, const View &view, const Rules &rules, const lens::Net &net,
                                const lens::PatchMap &map, uint32_t depth, Place &place) {
    bool outside;
    const Extremes z = depths(team, view, net, map, outside);
    if (z.high < view.near || outside) {
        return CULLED;
    }
    const Verdict split = depth < MAX_DEPTH ? SPLIT : TOO_CLOSE;
    if (z.low < view.near) {
        return smaller_than_half_pixel(team, view, net, map) ? CULLED : split;
    }
    if (view.perspective && z.high > DEPTH_RATIO * z.low) {
        return split;
    }
    Extremes x, y, d;
    const int count = net.count();
    for (int k = team.lane; k < count; k += LANES) {
        const Vec4 p = lens::apply(map, net.at(k));
        const double denominator = lens::denominator(view, p);
        x.add(p.x / denominator);
        y.add(p.y / denominator);
        d.add(denominator);
    }
    x = x.of(team), y = y.of(team), d = d.of(team);
    place.center[0] = round((x.low + x.high) * 0.5);
    place.center[1] = round((y.low + y.high) * 0.5);
    const double reach = max(max(max(x.high - place.center[0], place.center[0] - x.low), y.high - place.center[1]),
                             place.center[1] - y.low);
    const double span = max(x.high - x.low, y.high - y.low);
    const double most = double(max(net.degree_u, net.degree_v));
    if (most * span * (d.high / d.low - 1.0) * (1.0 / 4194304.0) > PARAMETER_BUDGET) {
        return split;
    }
    place.rounding = rounding_bound(net, reach);
    if (!(place.rounding <= ROUNDING_BUDGET)) {
        return split;
    }
    place.depth_origin = double(float((z.low + z.high) * 0.5));
    place.low = {x.low, y.low, z.low};
    place.high = {x.high, y.high, z.high};
    place.arithmetic = ARITHMETIC_F32;
    place.evaluation[0] = place.rounding;
    place.evaluation[1] = 0.0;
    if (rules.precision == ARITHMETIC_F32) {
        return KEEP;
    }
    const double relief = max(z.high - place.depth_origin, place.depth_origin - z.low);
    const precision::Hull hull =
        precision::hull_of(view, net.degree_u, net.degree_v, reach, d.high / d.low, z.low, place.depth_origin, relief);
    precision::Chosen chosen;
    if (!precision::choose(view, rules, hull, chosen)) {
        return split;
    }
    if (chosen.arithmetic != ARITHMETIC_F32) {
        place.arithmetic = chosen.arithmetic;
        place.evaluation[0] = chosen.pixels;
        place.evaluation[1] = chosen.depth * lens::pixel_size(view, z.high);
    }
    return KEEP;
}

// A control point on the screen, where halvings go by: behind the near plane depth stands in.
static __device__ __forceinline__ Vec3 halving_place(const View &view, const lens::Net &net, const lens::PatchMap &map,
                                                     int i, int j) {
    const Vec4 p = lens::apply(map, net.at(i, j));
    const double z = p.z / p.w;
    const double d = view.perspective ? max(z, view.near) : 1.0;
    const double depth = view.perspective ? z * view.scale / d : z * view.scale;
    return {p.x / p.w / d, p.y / p.w / d, z < view.near ? depth * 4.0 : depth};
}

// The direction in which the projected control polygons are longer. Sums have an order: one lane makes them.
template <int LANES>
static __device__ int longer_axis(const Team<LANES> &team, const View &view, const lens::Net &net,
                                  const lens::PatchMap &map) {
    int axis = 0;
    if (team.lane == 0) {
        const int m = net.degree_u, n = net.degree_v;
        double u = 0.0, v = 0.0;
        for (int i = 0; i < m; i++) {
            for (int j = 0; j <= n; j++) {
                u += length(halving_place(view, net, map, i, j) - halving_place(view, net, map, i + 1, j));
            }
        }
        for (int i = 0; i <= m; i++) {
            for (int j = 0; j < n; j++) {
                v += length(halving_place(view, net, map, i, j) - halving_place(view, net, map, i, j + 1));
            }
        }
        axis = v / double(m + 1) > u / double(n + 1);
    }
    return team.first(axis);
}

// The loops leave nothing of the rectangle of the patch's unit square.
static __device__ inline bool trimmed_away(const View &view, const scene::Scene &scene, const ScenePatch &patch,
                                    const double (&corner)[2], const double (&extent)[2]) {
    if (!view.trim || patch.tree == NO_TREE) {
        return false;
    }
    const trims::PlanePoint low = scene::to_plane(patch, corner[0], corner[1]);
    const trims::PlanePoint high = scene::to_plane(patch, corner[0] + extent[0], corner[1] + extent[1]);
    return trims::classify(scene.trims, patch.tree, trims::box_around(low, high)) == REGION_OUTSIDE;
}

} // namespace cull
