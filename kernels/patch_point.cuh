// A patch's net at one parameter: projected point, derivatives and normal in f32. Twin of the lower half of
// src/stages/newton.rs.
#pragma once
#include "topology.cuh"

// As x86 does it, so that both frames agree on what is not a number: the second, if either is NaN.
static __device__ __forceinline__ float larger(float a, float b) { return a > b ? a : b; }
static __device__ __forceinline__ float smaller(float a, float b) { return a < b ? a : b; }

// A patch as refinement sees it: `Surface` of the CPU.
struct Surface {
    Buffer<const Point> net;
    int degree[2];
    bool rational;
    bool perspective;
    float depth_origin;
    // What rounding may move a point, in pixels.
    float rounding;
    // Parameters that lie in its source patch: lower and upper ends.
    float domain[2][2];
    // What the depth may change beyond the surface's own slope, model units.
    float depth_tolerance;
    // Any sheet will do: refinement may cross silhouettes and change the depth.
    bool any_sheet;

    static __device__ __forceinline__ Surface of(const View &view, const Geometry &in, uint32_t patch, bool any_sheet) {
        const Patch p = in.patches[patch];
        const Leaf &leaf = in.leaves[patch];
        Surface s;
        s.net = in.nets + p.net;
        s.rational = leaf.rational != 0;
        s.perspective = view.perspective != 0;
        s.depth_origin = p.depth_origin;
        s.rounding = p.rounding;
        for (int k = 0; k < 2; k++) {
            s.degree[k] = p.degree[k];
            s.domain[k][0] = leaf.domain[k][0];
            s.domain[k][1] = leaf.domain[k][1];
        }
        s.depth_tolerance = leaf.depth_tolerance;
        s.any_sheet = any_sheet;
        return s;
    }
};

// The surface at one parameter, divided: pixels and depth about the patch's centre.
struct PatchPoint {
    float x, y, z;
    // Derivatives of x, y (pixels) and z (model units) by s and by t.
    float ds[3], dt[3];
    // S_u x S_v up to a positive factor, in the patch's pixel-homogeneous axes.
    float normal[3];
};

namespace patch_point {

// Coordinate c of a point.
static __device__ __forceinline__ float coordinate(const float4 &p, int c) {
    return c == 0 ? p.x : c == 1 ? p.y : c == 2 ? p.z : p.w;
}

// Values and derivatives of the Bernstein polynomials up to degree 3.
static __device__ __forceinline__ void small_basis(int degree, float t, float (&values)[4], float (&derivatives)[4]) {
    const float r = 1.0f - t;
    if (degree >= 3) {
        const float rr = r * r, rt = r * t, tt = t * t;
        values[0] = rr * r, values[1] = rt * r * 3.0f, values[2] = rt * t * 3.0f, values[3] = tt * t;
        derivatives[0] = rr * -3.0f, derivatives[1] = (rr - rt * 2.0f) * 3.0f;
        derivatives[2] = (rt * 2.0f - tt) * 3.0f, derivatives[3] = tt * 3.0f;
        return;
    }
    values[2] = values[3] = derivatives[2] = derivatives[3] = 0.0f;
    if (degree == 2) {
        values[0] = r * r, values[1] = r * t * 2.0f, values[2] = t * t;
        derivatives[0] = r * -2.0f, derivatives[1] = (r - t) * 2.0f, derivatives[2] = t * 2.0f;
    } else {
        values[0] = degree == 1 ? r : 1.0f, values[1] = degree == 1 ? t : 0.0f;
        derivatives[0] = degree == 1 ? -1.0f : 0.0f, derivatives[1] = degree == 1 ? 1.0f : 0.0f;
    }
}

// The same for any degree below N.
template <int N>
static __device__ __forceinline__ void basis(int degree, float t, float (&values)[N], float (&derivatives)[N]) {
    // Of degree - 1 first, in place of the values: that gives the derivatives, and one more step the values.
    float *low = values;
    for (int i = 0; i <= degree; i++) {
        low[i] = i == 0 ? 1.0f : 0.0f;
    }
    const float other = 1.0f - t;
    for (int d = 1; d < degree; d++) {
        float carried = 0.0f;
        for (int i = 0; i < d; i++) {
            const float old = low[i];
            low[i] = carried + other * old;
            carried = t * old;
        }
        low[d] = carried;
    }
    float before = 0.0f;
    for (int i = 0; i <= degree; i++) {
        const float here = i < degree ? low[i] : 0.0f;
        values[i] = t * before + other * here;
        derivatives[i] = (before - here) * float(degree);
        before = here;
    }
}

// A derivative divided by the weight, where the surface is at (x, y, z).
static __device__ __forceinline__ void tangent(float (&out)[3], const float (&q)[4], const float (&at)[3], float by_weight) {
#pragma unroll
    for (int k = 0; k < 3; k++) {
        out[k] = (q[k] - at[k] * q[3]) * by_weight;
    }
}

static __device__ __forceinline__ float denominator(const Surface &s, const float (&q)[4]) {
    return s.perspective ? q[2] + q[3] * s.depth_origin : q[3];
}

// The quotient rule, on the screen and for the normal.
static __device__ __forceinline__ PatchPoint divide(const Surface &s, const float (&p)[4], const float (&ps)[4],
                                                      const float (&pt)[4]) {
    const float inverse = 1.0f / denominator(s, p);
    const float d_s = denominator(s, ps), d_t = denominator(s, pt);
    const float by_weight = 1.0f / p[3];
    PatchPoint out;
    out.x = p[0] * inverse;
    out.y = p[1] * inverse;
    out.z = p[2] * by_weight;
    // Tangents in the patch's affine axes, for the normal.
    const float at[3] = {p[0] * by_weight, p[1] * by_weight, out.z};
    float a[3], b[3];
    tangent(a, ps, at, by_weight);
    tangent(b, pt, at, by_weight);
    out.normal[0] = a[1] * b[2] - a[2] * b[1];
    out.normal[1] = a[2] * b[0] - a[0] * b[2];
    out.normal[2] = a[0] * b[1] - a[1] * b[0];
    out.ds[0] = (ps[0] - out.x * d_s) * inverse;
    out.ds[1] = (ps[1] - out.y * d_s) * inverse;
    out.ds[2] = a[2];
    out.dt[0] = (pt[0] - out.x * d_t) * inverse;
    out.dt[1] = (pt[1] - out.y * d_t) * inverse;
    out.dt[2] = b[2];
    return out;
}

// Sums of the net's rows and columns; N: more than both degrees.
template <int N> static __device__ __forceinline__ PatchPoint sum(const Surface &surface, float s, float t) {
    const int m = surface.degree[0], n = surface.degree[1];
    float bu[N], du[N], bv[N], dv[N];
    if constexpr (N == 4) {
        small_basis(m, s, bu, du);
        small_basis(n, t, bv, dv);
    } else {
        basis(m, s, bu, du);
        basis(n, t, bv, dv);
    }
    const Buffer<const float4> net = as<const float4>(surface.net);
    float p[4] = {}, ps[4] = {}, pt[4] = {};
#pragma unroll (N == 4 ? 4 : 1)
    for (int i = 0; i < (N == 4 ? 4 : m + 1); i++) {
        if (i > m) {
            break;
        }
        float value[4] = {}, derivative[4] = {};
#pragma unroll (N == 4 ? 4 : 1)
        for (int j = 0; j < (N == 4 ? 4 : n + 1); j++) {
            if (j > n) {
                break;
            }
            const float4 q = __ldg(net + i * (n + 1) + j);
#pragma unroll
            for (int c = 0; c < 4; c++) {
                value[c] += bv[j] * coordinate(q, c);
                derivative[c] += dv[j] * coordinate(q, c);
            }
        }
#pragma unroll
        for (int c = 0; c < 4; c++) {
            p[c] += bu[i] * value[c];
            ps[c] += du[i] * value[c];
            pt[c] += bu[i] * derivative[c];
        }
    }
    if (!surface.rational) {
        // Polynomial nets have one weight; its derivatives are zero.
        p[3] = __ldg(net).w;
        ps[3] = pt[3] = 0.0f;
    }
    return divide(surface, p, ps, pt);
}

static __device__ __forceinline__ PatchPoint at(const Surface &surface, float s, float t) {
    const int degree = max(surface.degree[0], surface.degree[1]);
    // Up to bicubic everything stays in registers.
    return degree < 4 ? sum<4>(surface, s, t) : degree < 8 ? sum<8>(surface, s, t) : sum<64>(surface, s, t);
}

} // namespace patch_point
