// The parameters of a pixel on its triangle or stroke, before refinement. Twin of src/stages/interpolate.rs.
#pragma once
#include "stroke.cuh"

namespace interpolate {

// On a triangle: perspective-correct with the weights that the bound's interpolation asks for; from the nearest point where
// the centre is not inside.
static __device__ __forceinline__ float2 in_triangle(const Patch &patch, const Meshlet &m, const topology::Primitive &p,
                                                     const Corners &c, i64 px, i64 py) {
    const Triangle t = Triangle::of(c);
    stroke::Weights weights;
    bool outside = t.area == 0;
#pragma unroll
    for (int k = 0; k < 3; k++) {
        const i64 e = t.edge(k, px, py);
        outside = outside || e < 0;
        weights.w[k == 0 ? 2 : k - 1] = float(e);
    }
    if (outside) {
        weights = stroke::nearest_in_triangle(t, px, py);
    }
    // The corners in the triangle's order.
    const float scaled[3] = {weights.w[0] * c.v[0].weight, weights.w[1] * (t.turned ? c.v[2] : c.v[1]).weight,
                             weights.w[2] * (t.turned ? c.v[1] : c.v[2]).weight};
    const float sum = scaled[0] + scaled[1] + scaled[2];
    const float2 a = topology::parameters(patch, m, p.corner[0]);
    const float2 b = topology::parameters(patch, m, t.turned ? p.corner[2] : p.corner[1]);
    const float2 d = topology::parameters(patch, m, t.turned ? p.corner[1] : p.corner[2]);
    return make_float2((scaled[0] * a.x + scaled[1] * b.x + scaled[2] * d.x) / sum,
                       (scaled[0] * a.y + scaled[1] * b.y + scaled[2] * d.y) / sum);
}

static __device__ __forceinline__ float2 on_edge(const Patch &patch, const Meshlet &m, const topology::Primitive &p,
                                                 const Corners &c, i64 px, i64 py) {
    const Vertex &a = c.v[0], &b = c.v[1];
    const i64 dx = b.x - a.x, dy = b.y - a.y;
    const float s = stroke::nearest(dx * (px - a.x) + dy * (py - a.y), dx * dx + dy * dy);
    // Linear on the screen with the weights of the ends, so that the parameter is linear in space.
    const float wa = (1.0f - s) * a.weight, wb = s * b.weight;
    const float t = wb / (wa + wb);
    const float2 from = topology::parameters(patch, m, p.corner[0]), to = topology::parameters(patch, m, p.corner[1]);
    return make_float2(from.x + (to.x - from.x) * t, from.y + (to.y - from.y) * t);
}

// Patch parameters of a word at the pixel (x, y).
static __device__ __forceinline__ float2 at(const Geometry &in, const Patch &patch, const Meshlet &m, uint32_t index, int x,
                                            int y) {
    const topology::Primitive p = topology::primitive(m, patch.diagonal, index);
    const Corners c = topology::corners(in, m, p);
    return p.is_edge ? on_edge(patch, m, p, c, center_of(x), center_of(y))
                     : in_triangle(patch, m, p, c, center_of(x), center_of(y));
}

} // namespace interpolate
