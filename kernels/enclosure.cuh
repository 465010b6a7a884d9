// Second-derivative enclosures of a piece of a patch, by one warp. Twin of src/scene/enclosure.rs and
// src/geometry/bernstein.rs, where everything is explained: polynomials are in scaled Bernstein form, and sums run in the
// CPU's order, each by one lane.
#pragma once
#include "bounds.cuh"

namespace enclosure {

using Warp = Team<32>;

// Memory of one warp, handed out from its start.
struct Scratch {
    Buffer<double> next;

    __device__ __forceinline__ Buffer<double> take(int numbers) {
        const Buffer<double> taken = next;
        next = next + (numbers + 1) / 2 * 2;
        return taken;
    }
};

// A polynomial with C components a coefficient, u outermost.
template <int C> struct Polynomial {
    Buffer<double> scaled;
    int m, n;

    __device__ __forceinline__ int count() const { return (m + 1) * (n + 1); }
};

// C(degree, k).
static __device__ double binomial(int degree, int k) {
    double value = 1.0;
    for (int i = 0; i < k; i++) {
        value = value * double(degree - i) / double(i + 1);
    }
    return value;
}

static __device__ __forceinline__ double scale_of(int m, int n, int k) {
    return binomial(m, k / (n + 1)) * binomial(n, k % (n + 1));
}

template <int C>
static __device__ __noinline__ Polynomial<C> product(const Warp &warp, const Polynomial<C> &a, const Polynomial<1> &b, Buffer<double> out) {
    const int m = a.m + b.m, n = a.n + b.n;
    for (int k = warp.lane; k < (m + 1) * (n + 1) * C; k += 32) {
        const int c = k % C, row = k / C / (n + 1), column = k / C % (n + 1);
        double sum = 0.0;
        for (int i = max(0, row - b.m); i <= min(a.m, row); i++) {
            for (int j = max(0, column - a.n); j <= min(b.n, column); j++) {
                const double factor = b.scaled[(row - i) * (b.n + 1) + j];
                sum = sum + a.scaled[(i * (a.n + 1) + column - j) * C + c] * factor;
            }
        }
        out[k] = sum;
    }
    warp.sync();
    return {out, m, n};
}

template <int C>
static __device__ Polynomial<C> derivative(const Warp &warp, const Polynomial<C> &a, int axis, Buffer<double> out) {
    const int m = a.m - (axis == 0), n = a.n - (axis == 1);
    const int count = axis == 0 ? a.m : a.n, step = (axis == 0 ? a.n + 1 : 1) * C;
    for (int k = warp.lane; k < (m + 1) * (n + 1) * C; k += 32) {
        const int c = k % C, i = k / C / (n + 1), j = k / C % (n + 1);
        const int order = axis == 0 ? i : j, at = (i * (a.n + 1) + j) * C + c;
        out[k] = a.scaled[at + step] * double(order + 1) - a.scaled[at] * double(count - order);
    }
    warp.sync();
    return {out, m, n};
}

// a + b * factor, in a's place; of the same degree.
static __device__ void add(const Warp &warp, const Polynomial<3> &a, const Polynomial<3> &b, double factor) {
    for (int k = warp.lane; k < a.count() * 3; k += 32) {
        a.scaled[k] = a.scaled[k] + b.scaled[k] * factor;
    }
    warp.sync();
}

// The two halves of a net along an axis, by de Casteljau: the upper one in its place.
static __device__ __noinline__ void halve(const Warp &warp, Buffer<ControlPoint> high, Buffer<ControlPoint> low, int m, int n, int axis) {
    const int count = axis == 0 ? m + 1 : n + 1, stride = axis == 0 ? n + 1 : 1;
    const int lines = axis == 0 ? n + 1 : m + 1, next_line = axis == 0 ? 1 : n + 1;
    for (int line = warp.lane; line < lines; line += 32) {
        const int first = line * next_line;
        low[first] = high[first];
        for (int level = 1; level < count; level++) {
            for (int k = 0; k < count - level; k++) {
                const ControlPoint a = high[first + k * stride], b = high[first + (k + 1) * stride];
                high[first + k * stride] = {a.x * 0.5 + b.x * 0.5, a.y * 0.5 + b.y * 0.5, a.z * 0.5 + b.z * 0.5,
                                            a.w * 0.5 + b.w * 0.5};
            }
            low[first + level * stride] = high[first];
        }
    }
    warp.sync();
}

// Boxes and radii over some nets: a lane's own, and then of all.
struct Hull {
    Extremes x, y, z;
    double radius = 0.0;

    __device__ void add(const Warp &warp, Buffer<const ControlPoint> points, int count) {
        for (int k = warp.lane; k < count; k += 32) {
            const ControlPoint p = points[k];
            const Vec3 s = Vec3{p.x, p.y, p.z} / p.w;
            x.add(s.x), y.add(s.y), z.add(s.z);
            radius = max(radius, length(s));
        }
    }

    // Outwards by what rounding may have taken.
    __device__ void into(const Warp &warp, bounds::Enclosure &e, int k) const {
        const Extremes all_x = x.of(warp), all_y = y.of(warp), all_z = z.of(warp);
        const double most = warp.most(radius);
        if (warp.lane != 0) {
            return;
        }
        const double slack = most * 1e-13;
        const Vec3 slacks = {slack, slack, slack};
        e.low[k] = Vec3{all_x.low, all_y.low, all_z.low} - slacks;
        e.high[k] = Vec3{all_x.high, all_y.high, all_z.high} + slacks;
        e.radius[k] = most * (1.0 + 1e-13);
    }
};

// Hulls of the quarters of a net of degree (m, n) in `net`; two more of its size follow it.
static __device__ __noinline__ void enclose_quarters(const Warp &warp, Buffer<ControlPoint> net, int m, int n, bounds::Enclosure &e, int k) {
    const int count = (m + 1) * (n + 1);
    Hull hull;
    if (count == 1) {
        hull.add(warp, net, 1);
    } else {
        const Buffer<ControlPoint> low = net + count, quarter = net + 2 * count;
        halve(warp, net, low, m, n, 0);
        for (int half = 0; half < 2; half++) {
            const Buffer<ControlPoint> rest = half ? net : low;
            halve(warp, rest, quarter, m, n, 1);
            hull.add(warp, quarter, count);
            hull.add(warp, rest, count);
            warp.sync();
        }
    }
    hull.into(warp, e, k);
    warp.sync();
}

// Weights differ by more than rounding.
static __device__ bool is_rational(const Warp &warp, const lens::Net &net) {
    const double first = net.at(0).w;
    bool same = true;
    for (int k = warp.lane; k < net.count(); k += 32) {
        same = same && !(fabs(net.at(k).w - first) > 1e-14 * fabs(first));
    }
    return !warp.all(same);
}

static __device__ void of_polynomial(const Warp &warp, const lens::Net &net, Scratch scratch, bounds::Enclosure &e) {
    const int m = net.degree_u, n = net.degree_v;
    const double inverse = 1.0 / net.at(0).w;
    const Buffer<ControlPoint> out = as<ControlPoint>(scratch.next);
    for (int which = 0; which < 3; which++) {
        const int du = 2 - which, dv = which;
        if (m < du || n < dv) {
            if (warp.lane == 0) {
                out[0] = {0.0, 0.0, 0.0, 1.0};
            }
            warp.sync();
            enclose_quarters(warp, out, 0, 0, e, which);
            continue;
        }
        const double factor = which == 0 ? double(m * (m - 1)) : which == 1 ? double(m * n) : double(n * (n - 1));
        const int columns = n + 1 - dv;
        for (int k = warp.lane; k < (m + 1 - du) * columns; k += 32) {
            const int i = k / columns, j = k % columns;
            const Vec4 zero = {0.0, 0.0, 0.0, 0.0};
            Vec4 sum;
            if (which == 1) {
                sum = zero + net.at(i, j) * 1.0 + net.at(i + 1, j) * -1.0 + net.at(i, j + 1) * -1.0 + net.at(i + 1, j + 1) * 1.0;
            } else {
                const int a = which == 0, b = which == 2;
                sum = zero + net.at(i, j) * 1.0 + net.at(i + a, j + b) * -2.0 + net.at(i + 2 * a, j + 2 * b) * 1.0;
            }
            const Vec3 d = truncated(sum) * (factor * inverse);
            out[k] = {d.x, d.y, d.z, 1.0};
        }
        warp.sync();
        enclose_quarters(warp, out, m - du, n - dv, e, which);
    }
}

static __device__ void of_rational(const Warp &warp, const lens::Net &net, Scratch scratch, bounds::Enclosure &e) {
    const int m = net.degree_u, n = net.degree_v, count = net.count(), room = (3 * m + 1) * (3 * n + 1);
    Vec3 center = {0.0, 0.0, 0.0};
    // Sums have an order: every lane makes the same one.
    for (int k = 0; k < count; k++) {
        center = center + net.place(k);
    }
    center = center / double(count);
    const Polynomial<3> p = {scratch.take(3 * count), m, n};
    const Polynomial<1> w = {scratch.take(count), m, n};
    for (int k = warp.lane; k < count; k += 32) {
        const double scale = scale_of(m, n, k);
        const Vec4 q = net.at(k);
        const Vec3 s = (truncated(q) - center * q.w) * scale;
        p.scaled[3 * k] = s.x, p.scaled[3 * k + 1] = s.y, p.scaled[3 * k + 2] = s.z;
        w.scaled[k] = q.w * scale;
    }
    warp.sync();
    const Polynomial<1> slope_u = derivative(warp, w, 0, scratch.take(count));
    const Polynomial<1> slope_v = derivative(warp, w, 1, scratch.take(count));
    const Polynomial<1> square = product(warp, w, w, scratch.take(room));
    const Polynomial<1> cube = product(warp, square, w, scratch.take(room));
    const Buffer<double> first = scratch.take(3 * room), second = scratch.take(3 * room), third = scratch.take(3 * room);
    const Buffer<double> ones = scratch.take(4);
    const Buffer<ControlPoint> out = as<ControlPoint>(scratch.next);
    for (int which = 0; which < 3; which++) {
        const int a = which == 2, b = which > 0;
        // S_a = D_a / w^2, S_ab = (D_ab w - 2 D_a w_b) / w^3.
        const Polynomial<3> lead = product(warp, derivative(warp, p, a, second), w, first);
        add(warp, lead, product(warp, p, a ? slope_v : slope_u, second), -1.0);
        const Polynomial<3> numerator = product(warp, derivative(warp, lead, b, second), w, third);
        add(warp, numerator, product(warp, lead, b ? slope_v : slope_u, second), -2.0);
        const Polynomial<1> one = {ones, 3 * m - numerator.m, 3 * n - numerator.n};
        for (int k = warp.lane; k < one.count(); k += 32) {
            ones[k] = 1.0 * scale_of(one.m, one.n, k);
        }
        warp.sync();
        const Polynomial<3> raised = product(warp, numerator, one, second);
        for (int k = warp.lane; k < room; k += 32) {
            const double scale = 1.0 / scale_of(3 * m, 3 * n, k);
            out[k] = {raised.scaled[3 * k] * scale, raised.scaled[3 * k + 1] * scale, raised.scaled[3 * k + 2] * scale,
                      cube.scaled[k] * scale};
        }
        warp.sync();
        enclose_quarters(warp, out, 3 * m, 3 * n, e, which);
    }
}

// Of a net; the warp's first lane writes. SceneOnDevice in src/cuda/scene.rs says how much memory that takes.
static __device__ void of_net(const Warp &warp, const lens::Net &net, Scratch scratch, bounds::Enclosure &e) {
    if (is_rational(warp, net)) {
        of_rational(warp, net, scratch, e);
    } else {
        of_polynomial(warp, net, scratch, e);
    }
}

} // namespace enclosure
