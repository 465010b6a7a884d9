// The five tessellation bounds as constraints on the grid. Twin of src/stages/bounds.rs, where everything is explained.
#pragma once
#include "judge.cuh"

namespace bounds {

using lens::Net;
using lens::PatchMap;

// Second derivatives of the surface: S_uu, S_uv, S_vv.
struct Enclosure {
    Vec3 low[3], high[3];
    double radius[3];
};

static __device__ __forceinline__ Enclosure enclosure_of(const ScenePatch &patch) {
    Enclosure e;
#pragma unroll
    for (int k = 0; k < 3; k++) {
        e.low[k] = load_vector(patch.enclosure_low[k]);
        e.high[k] = load_vector(patch.enclosure_high[k]);
        e.radius[k] = patch.enclosure_radius[k];
    }
    return e;
}

// a / nu^2 + b / (nu nv) + c / nv^2 <= 1, with b for either diagonal.
struct Constraint {
    double a, b[2], c;

    // The share of the tolerance that a grid uses up.
    __device__ __forceinline__ double share(int diagonal, double nu, double nv) const {
        return a / (nu * nu) + (diagonal ? b[1] : b[0]) / (nu * nv) + c / (nv * nv);
    }
};

// Two ends of two axes with two signs, and two signs of depth.
constexpr int CAPACITY = 10;
// Numbers that a list takes.
constexpr int NUMBERS = 4 * CAPACITY;

// A list of constraints in shared memory, `stride` numbers apart; a team's first lane writes.
struct Constraints {
    Span<double> numbers;
    int stride;
    bool writes;
    int count = 0;
    // Where those on depth begin: the ones before are on pixels.
    int depth = 0;
    // A direction in which the leaf is narrower than the tolerance has none.
    bool narrow = false;

    __device__ __forceinline__ Constraint at(int k) const {
        const Span<double> n = numbers + 4 * k * stride;
        return {n[0], {n[stride], n[2 * stride]}, n[3 * stride]};
    }

    __device__ __forceinline__ void push(const Constraint &q) {
        const bool some = q.a > 0.0 || q.c > 0.0;
        const double b[2] = {some || q.b[0] > 0.0 ? q.b[0] : 0.0, some || q.b[1] > 0.0 ? q.b[1] : 0.0};
        if (!some && !(b[0] > 0.0) && !(b[1] > 0.0)) {
            return;
        }
        if (writes) {
            const Span<double> n = numbers + 4 * count * stride;
            n[0] = q.a;
            n[stride] = b[0];
            n[2 * stride] = b[1];
            n[3 * stride] = q.c;
        }
        count++;
    }
};

// Pixels a side of the boxes that small triangles fit.
constexpr double SMALL_TRIANGLE = 16.0;

// What a bound looks at.
struct Subject {
    const View &view;
    const PatchMap &map;
    const Net &net;
    const cull::Place &place;
    double tolerance;
    double depth_tolerance;

    __device__ __forceinline__ double low(int axis) const { return axis ? place.low.y : place.low.x; }
    __device__ __forceinline__ double high(int axis) const { return axis ? place.high.y : place.high.x; }

    // The pixels at which an axis' bound is taken; false: the leaf is narrower than the tolerance.
    __device__ __forceinline__ bool ends(int axis, double (&ends)[2]) const {
        const double half = lens::half_image(view, axis);
        ends[0] = max(low(axis) + tolerance, -half);
        ends[1] = min(high(axis) - tolerance, half);
        return high(axis) - low(axis) > tolerance;
    }

    __device__ __forceinline__ double z_min() const { return view.perspective ? place.low.z : 1.0; }

    // The direction in which pixel xi's plane of an axis faces.
    __device__ __forceinline__ Vec3 facing(int axis, double xi) const {
        return (axis ? map.axes[1] : map.axes[0]) * view.scale - map.axes[2] * (view.perspective ? xi : 0.0);
    }
};

struct Interval {
    double low, high;
};

static __device__ __forceinline__ Interval along(const Enclosure &e, int k, Vec3 q, double length) {
    const double middle = dot(q, e.low[k] + e.high[k]) * 0.5;
    const double spread = dot(absolute(q), e.high[k] - e.low[k]) * 0.5;
    const double ball = length * e.radius[k];
    return {max(middle - spread, -ball), min(middle + spread, ball)};
}

// Both signs of one direction.
template <class Take>
static __device__ __forceinline__ void signed_pair(const Enclosure &e, Vec3 q, double unit, Take take) {
    const double length = ::length(q);
    const Interval uu = along(e, 0, q, length), uv = along(e, 1, q, length), vv = along(e, 2, q, length);
    const double half_width = (uv.high - uv.low) * 0.5;
#pragma unroll
    for (int positive = 1; positive >= 0; positive--) {
        const double a = max(positive ? uu.high : -uu.low, 0.0);
        const double c = max(positive ? vv.high : -vv.low, 0.0);
        const double with = max(half_width, uv.high), against = max(half_width, -uv.low);
        const double b0 = positive ? with : against, b1 = positive ? against : with;
        take(Constraint{a * unit, {2.0 * b0 * unit, 2.0 * b1 * unit}, c * unit});
    }
}

// M7bn.
static __device__ void screen(const Subject &s, const Enclosure &e, Constraints &out) {
    const double unit = 1.0 / (8.0 * s.tolerance * s.z_min());
    for (int axis = 0; axis < 2; axis++) {
        double ends[2];
        if (!s.ends(axis, ends)) {
            out.narrow = true;
            continue;
        }
        for (int k = 0; k < (s.view.perspective ? 2 : 1); k++) {
            signed_pair(e, s.facing(axis, k ? ends[1] : ends[0]), unit, [&](const Constraint &c) { out.push(c); });
        }
    }
    out.depth = out.count;
    signed_pair(e, s.map.axes[2], 1.0 / (8.0 * s.depth_tolerance), [&](const Constraint &c) { out.push(c); });
}

// `screen` read the other way round, for all pixels that see the leaf: pixels and depth that a grid is off by.
static __device__ void affine_deviation(const Subject &s, const Enclosure &e, int diagonal, double nu, double nv,
                                        double &pixels, double &depth) {
    double off = 0.0;
    const auto take = [&](const Constraint &c) { off = max(off, c.share(diagonal, nu, nv)); };
    for (int axis = 0; axis < 2; axis++) {
        const double half = lens::half_image(s.view, axis);
        for (int k = 0; k < (s.view.perspective ? 2 : 1); k++) {
            const double xi = clamped(k ? s.high(axis) : s.low(axis), -half, half);
            signed_pair(e, s.facing(axis, xi), 1.0 / (8.0 * s.z_min()), take);
        }
    }
    pixels = off;
    off = 0.0;
    signed_pair(e, s.map.axes[2], 1.0 / 8.0, take);
    depth = off;
}

// ETER section 4.1: the radius of a cube about any point of the leaf whose projection stays within the tolerance.
template <int LANES> static __device__ double object_epsilon(const Team<LANES> &team, const Subject &s) {
    if (!s.view.perspective) {
        return s.tolerance / s.view.scale;
    }
    double reach_x = 0.0, reach_y = 0.0;
    for (int k = team.lane; k < s.net.count(); k += LANES) {
        const Vec4 p = s.net.at(k);
        reach_x = max(reach_x, fabs(dot(s.map.rows[0], p) / p.w));
        reach_y = max(reach_y, fabs(dot(s.map.rows[1], p) / p.w));
    }
    const double z = s.place.low.z;
    const double tau = s.tolerance / s.view.scale;
    const double x = z * tau / (1.0 + team.most(reach_x) / s.view.scale / z + tau);
    const double y = z * tau / (1.0 + team.most(reach_y) / s.view.scale / z + tau);
    return min(x, y);
}

template <int LANES> static __device__ double isotropic_epsilon(const Team<LANES> &team, const Subject &s) {
    return min(object_epsilon(team, s), s.depth_tolerance);
}

// Largest stretch of an instance.
static __device__ double axis_scale(const PatchMap &map) {
    const double x = length(map.axes[0]), y = length(map.axes[1]), z = length(map.axes[2]);
    const bool similar = max(fabs(x - y), fabs(x - z)) <= 1e-9 * x;
    const double norm = sqrt(x * x + y * y + z * z);
    return similar ? norm / sqrt(3.0) * (1.0 + 1e-9) : norm;
}

// M3.
template <int LANES>
static __device__ void filip(const Team<LANES> &team, const Subject &s, const Enclosure &e, Constraints &out) {
    const double unit = 1.0 / (8.0 * isotropic_epsilon(team, s));
    const double scale = axis_scale(s.map);
    const double b = 2.0 * e.radius[1] * unit * scale;
    out.push({e.radius[0] * unit * scale, {b, b}, e.radius[2] * unit * scale});
}

struct Seconds {
    double uu, uv, vv;
};

// Largest `size` of the control points of F_uu, F_uv, F_vv, where `p(i, j)` are those of F.
template <int LANES, class Points, class Size>
static __device__ Seconds second_differences(const Team<LANES> &team, int m, int n, Points p, Size size) {
    Seconds most = {0.0, 0.0, 0.0};
    for (int k = team.lane; k < (m + 1) * (n + 1); k += LANES) {
        const int i = k / (n + 1), j = k % (n + 1);
        if (i + 2 <= m) {
            most.uu = max(most.uu, size(p(i + 2, j) - p(i + 1, j) * 2.0 + p(i, j)));
        }
        if (j + 2 <= n) {
            most.vv = max(most.vv, size(p(i, j + 2) - p(i, j + 1) * 2.0 + p(i, j)));
        }
        if (i < m && j < n) {
            most.uv = max(most.uv, size(p(i + 1, j + 1) - p(i, j + 1) - p(i + 1, j) + p(i, j)));
        }
    }
    const double u = m, v = n;
    return {team.most(most.uu) * u * (u - 1.0), team.most(most.uv) * u * v, team.most(most.vv) * v * (v - 1.0)};
}

// A ball about a net.
struct Ball {
    Vec3 origin;
    double radius;
    // The least weight of its points.
    double weight;
};

template <int LANES> static __device__ Ball ball(const Team<LANES> &team, const Subject &s) {
    Extremes x, y, z, w;
    for (int k = team.lane; k < s.net.count(); k += LANES) {
        const Vec3 p = s.net.place(k);
        x.add(p.x), y.add(p.y), z.add(p.z), w.add(s.net.at(k).w);
    }
    x = x.of(team), y = y.of(team), z = z.of(team), w = w.of(team);
    const Vec3 origin = Vec3{x.low + x.high, y.low + y.high, z.low + z.high} * 0.5;
    double radius = 0.0;
    for (int k = team.lane; k < s.net.count(); k += LANES) {
        radius = max(radius, length(s.net.place(k) - origin));
    }
    return {origin, team.most(radius), w.low};
}

// The fewest quads whose triangles fit boxes of 16 x 16 pixels: ETER's equation (2).
template <int LANES> static __device__ void small_triangles(const Team<LANES> &team, const Subject &s, double (&quads)[2]) {
    const Subject large = {s.view, s.map, s.net, s.place, SMALL_TRIANGLE, s.depth_tolerance};
    const double epsilon = object_epsilon(team, large) / axis_scale(s.map);
    const Ball all = ball(team, s);
    quads[0] = quads[1] = 1.0;
    if (epsilon >= 2.0 * all.radius) {
        return;
    }
    const double reach = max(all.radius - epsilon, 0.0);
    const auto size = [&](Vec4 d) { return length(truncated(d) - all.origin * d.w) + reach * fabs(d.w); };
    const int m = s.net.degree_u, n = s.net.degree_v;
    double u = 0.0, v = 0.0;
    for (int k = team.lane; k < (m + 1) * (n + 1); k += LANES) {
        const int i = k / (n + 1), j = k % (n + 1);
        if (i < m) {
            u = max(u, size(s.net.at(i + 1, j) - s.net.at(i, j)));
        }
        if (j < n) {
            v = max(v, size(s.net.at(i, j + 1) - s.net.at(i, j)));
        }
    }
    const double unit = 2.0 / (epsilon * all.weight);
    quads[0] = max(ceil(team.most(u) * double(m) * unit), 1.0);
    quads[1] = max(ceil(team.most(v) * double(n) * unit), 1.0);
}

// M1, in terms of the share of `epsilon` that is used up; points are within `drawn_in` of where their net allows.
template <int LANES, class Take>
static __device__ void eter_within(const Team<LANES> &team, const Subject &s, double epsilon, double drawn_in, Take take) {
    const double stretch = axis_scale(s.map);
    epsilon = epsilon / stretch, drawn_in = drawn_in / stretch;
    const Ball all = ball(team, s);
    if (drawn_in >= 2.0 * all.radius) {
        return;
    }
    const double reach = max(all.radius - drawn_in, 0.0);
    const Seconds most = second_differences(
        team, s.net.degree_u, s.net.degree_v, [&](int i, int j) { return s.net.at(i, j); },
        [&](Vec4 d) { return length(truncated(d) - all.origin * d.w) + reach * fabs(d.w); });
    const double unit = 1.0 / (8.0 * epsilon * all.weight);
    const double b = 2.0 * most.uv * unit;
    take(Constraint{most.uu * unit, {b, b}, most.vv * unit});
}

// M4: second differences of the clip-space net, per axis.
template <int LANES> static __device__ void projective(const Team<LANES> &team, const Subject &s, Constraints &out) {
    const View &view = s.view;
    const cull::Place &place = s.place;
    // The leaf's own net, as it is rounded for drawing.
    const auto point = [&](int i, int j) {
        const Vec4 p = lens::apply(s.map, s.net.at(i, j));
        const double d = lens::denominator(view, p);
        return Vec4{double(float(p.x - place.center[0] * d)), double(float(p.y - place.center[1] * d)),
                    double(float(p.z - place.depth_origin * p.w)), double(float(p.w))};
    };
    const auto denominator = [&](Vec4 p) { return view.perspective ? p.z + place.depth_origin * p.w : p.w; };
    Extremes d, w;
    const int across = s.net.degree_v + 1;
    for (int k = team.lane; k < s.net.count(); k += LANES) {
        const Vec4 p = point(k / across, k % across);
        d.add(denominator(p)), w.add(p.w);
    }
    d = d.of(team), w = w.of(team);
    const auto push = [&](double unit, auto value) {
        const Seconds most = second_differences(team, s.net.degree_u, s.net.degree_v, point,
                                                [&](Vec4 p) { return fabs(value(p)); });
        const double b = 2.0 * most.uv * unit;
        out.push({most.uu * unit, {b, b}, most.vv * unit});
    };
    for (int axis = 0; axis < 2; axis++) {
        double ends[2];
        const bool wide = s.ends(axis, ends);
        for (int k = 0; wide && k < 2; k++) {
            const double xi = (k ? ends[1] : ends[0]) - (axis ? place.center[1] : place.center[0]);
            push(1.0 / (8.0 * s.tolerance * d.low), [&](Vec4 p) { return (axis ? p.y : p.x) - xi * denominator(p); });
        }
    }
    const double near = place.low.z - place.depth_origin, far = place.high.z - place.depth_origin;
    const double t = s.depth_tolerance;
    for (int k = 0; far - near > t && k < 2; k++) {
        const double zeta = k ? far - t : near + t;
        push(1.0 / (8.0 * t * w.low), [&](Vec4 p) { return p.z - zeta * p.w; });
    }
}

} // namespace bounds
