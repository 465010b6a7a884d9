// What the kernels that evaluate meshlets into memory have in common.
#pragma once
#include "abi.h"
#include "count.cuh"

namespace evaluate {

// Meshlets a block: one a warp.
constexpr int WARPS = 4;

// What a launch is given, besides the view.
struct Buffers {
    Buffer<const Patch> patches;
    Buffer<const Meshlet> meshlets;
    Buffer<const Point> nets;
    Buffer<const float> basis;
    Buffer<Vertex> vertices;
};

// A point of the patch to its pixel and stored depth: `Projector::vertex` of the CPU.
static __device__ __forceinline__ Vertex project(const View &view, const Patch &patch, float4 p) {
    const bool perspective = view.perspective != 0;
    const float denominator = perspective ? p.z + patch.depth_origin * p.w : p.w;
    Vertex v;
    v.x = patch.base[0] + __float2int_rn(p.x / denominator * float(SUBPIXELS));
    v.y = patch.base[1] + __float2int_rn(p.y / denominator * float(SUBPIXELS));
    const float depth = perspective ? view.near_f32 * p.w / denominator
                                    : patch.depth_offset - view.depth_slope * (p.z / p.w);
    // A hull that touches the near plane may round past it; 2^-126 is the least normal number.
    v.depth = fminf(fmaxf(depth, 1.17549435e-38f), 1.0f);
    v.weight = view.projective ? 1.0f / denominator : perspective ? v.depth : 1.0f;
    return v;
}

// sum + c * b, rounded twice: contraction is off.
static __device__ __forceinline__ float4 add_scaled(float4 sum, float4 c, float b) {
    return make_float4(sum.x + c.x * b, sum.y + c.y * b, sum.z + c.z * b, sum.w + c.w * b);
}

// First and last Bernstein value of a grid's line that is not zero: at both ends only one is left.
static __device__ __forceinline__ int2 terms_of(int line, int quads, int degree) {
    return make_int2(line == quads ? degree : 0, line == 0 ? 0 : degree);
}

// One vertex of a patch's grid by itself: the words of evaluate_f32.
static __device__ __forceinline__ Vertex vertex(const View &view, const Patch &patch, Buffer<const Point> nets,
                                                Buffer<const float> basis, int row, int column) {
    const int degree_u = patch.degree[0], degree_v = patch.degree[1];
    const Buffer<const float4> net = as<const float4>(nets + patch.net);
    const Buffer<const float> along_u = basis + patch.basis[0] + row * (degree_u + 1);
    const Buffer<const float> along_v = basis + patch.basis[1] + column * (degree_v + 1);
    const int2 u = terms_of(row, patch.quads[0], degree_u), v = terms_of(column, patch.quads[1], degree_v);
    float4 point = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
    for (int j = v.x; j <= v.y; j++) {
        float4 sum = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
        for (int i = u.x; i <= u.y; i++) {
            sum = add_scaled(sum, __ldg(net + i * (degree_v + 1) + j), __ldg(along_u + i));
        }
        point = add_scaled(point, sum, __ldg(along_v + j));
    }
    return project(view, patch, point);
}

} // namespace evaluate
