// What the kernels that evaluate points with tangents and normals have in common. They know no view: nets are homogeneous in
// any space, about the patch's own origin.
#pragma once
#include "abi.h"
#include "compat.cuh"

namespace surface {

// Meshlets a block: one a warp.
constexpr int WARPS = 4;

// What a launch is given.
struct Buffers {
    Buffer<const Patch> patches;
    Buffer<const Meshlet> meshlets;
    Buffer<const Point> nets;
    Buffer<const float> basis;
    // Derivatives of the Bernstein values, at the same places.
    Buffer<const float> slopes;
};

// The homogeneous point and its derivatives.
struct Sums {
    float4 point, along_u, along_v;
};

static __device__ __forceinline__ float3 scaled(float4 p, float factor) {
    return make_float3(p.x * factor, p.y * factor, p.z * factor);
}

// The quotient rule: (R_u - S w_u) / w.
static __device__ __forceinline__ float3 tangent(float4 along, float3 position, float reciprocal) {
    const float4 numerator = make_float4(__fmaf_rn(-position.x, along.w, along.x), __fmaf_rn(-position.y, along.w, along.y),
                                         __fmaf_rn(-position.z, along.w, along.z), 0.0f);
    return scaled(numerator, reciprocal);
}

// The unit vector along a x b; 0 where they are parallel.
static __device__ __forceinline__ float3 unit_normal(float3 a, float3 b) {
    const float3 n = make_float3(__fmaf_rn(a.y, b.z, -(a.z * b.y)), __fmaf_rn(a.z, b.x, -(a.x * b.z)),
                                 __fmaf_rn(a.x, b.y, -(a.y * b.x)));
    // Squares of short ones would vanish.
    const float largest = fmaxf(fmaxf(fabsf(n.x), fabsf(n.y)), fabsf(n.z));
    const float scale = largest > 1e-37f ? approximate_reciprocal(largest) : 0.0f;
    const float x = n.x * scale, y = n.y * scale, z = n.z * scale;
    const float inverse = largest > 1e-37f ? rsqrtf(__fmaf_rn(x, x, __fmaf_rn(y, y, z * z))) : 0.0f;
    return make_float3(x * inverse, y * inverse, z * inverse);
}

static __device__ __forceinline__ void store(Buffer<SurfacePoint> to, const Sums &sums) {
    const float reciprocal = 1.0f / sums.point.w;
    const float3 p = scaled(sums.point, reciprocal);
    const float3 n = unit_normal(tangent(sums.along_u, p, reciprocal), tangent(sums.along_v, p, reciprocal));
    to[0] = {{p.x, p.y, p.z}, {n.x, n.y, n.z}};
}

static __device__ __forceinline__ void store(Buffer<SurfaceFrame> to, const Sums &sums) {
    const float reciprocal = 1.0f / sums.point.w;
    const float3 p = scaled(sums.point, reciprocal);
    const float3 u = tangent(sums.along_u, p, reciprocal);
    const float3 v = tangent(sums.along_v, p, reciprocal);
    const float3 n = unit_normal(u, v);
    to[0] = {{p.x, p.y, p.z}, {u.x, u.y, u.z}, {v.x, v.y, v.z}, {n.x, n.y, n.z}};
}

static __device__ __forceinline__ void add_scaled(float4 &sum, float4 c, float b) {
    sum = make_float4(__fmaf_rn(c.x, b, sum.x), __fmaf_rn(c.y, b, sum.y), __fmaf_rn(c.z, b, sum.z), __fmaf_rn(c.w, b, sum.w));
}

static __device__ __forceinline__ float4 zero4() { return make_float4(0.0f, 0.0f, 0.0f, 0.0f); }

} // namespace surface

// A kernel of `WARPS * 32` threads whose parameters are all of `Buffers`, what it writes and the number of meshlets.
#define SURFACE_KERNEL(name, Output, ...)                                                                              \
    extern "C" __global__ void __launch_bounds__(surface::WARPS * 32)                                                  \
        name(Buffer<const Patch> patches, Buffer<const Meshlet> meshlets, Buffer<const Point> nets,                    \
             Buffer<const float> basis, Buffer<const float> slopes, Buffer<Output> points, uint32_t count) {           \
        __VA_ARGS__({patches, meshlets, nets, basis, slopes}, points, count);                                          \
    }                                                                                                                  \
    KERNEL(name)
