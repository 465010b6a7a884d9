// What the kernels that evaluate meshlets into memory have in common.
#pragma once
#include "abi.h"
#include "compat.cuh"

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

} // namespace evaluate
