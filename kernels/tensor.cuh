// Numbers as tensor cores take them, with and without low parts, and products of 8 x 8 matrices in a warp.
//
// Lane l is (g, t) = (l / 4, l % 4). mma.sync hands out D as it wants A, so a product's result is the next one's left side.
#pragma once
#include "abi.h"
#include "compat.cuh"

namespace tensor {

// Elements 2t and 2t + 1 of a row of A or a column of B.
struct F16 {
    using Pair = uint32_t;
    static constexpr bool SCALED = true;

    // Which pair of rows of B the lane holds.
    static __device__ __forceinline__ int rows_of_b(int t) { return t; }
    static __device__ __forceinline__ Pair zero() { return 0; }
    static __device__ __forceinline__ Pair round(float2 x) { return pack_half2(x.x, x.y); }
    static __device__ __forceinline__ float2 value(Pair p) { return unpack_half2(p); }
    // [rows 0 to 7; rows 8 to 15] B + C
    static __device__ __forceinline__ void multiply(float (&d)[4], Pair upper, Pair lower, Pair b, const float (&c)[4]) {
        const uint32_t rows[2] = {upper, lower};
        const uint32_t column[1] = {b};
        mma_m16n8k8_f16(d, rows, column, c);
    }
};

// ETER section 7.1's sparse product, half of whose A is empty: D is laid out as what is left of A. Pair t of A stands in
// columns 4t and 4t + 1 for t = 0, 1 and in 4t + 2 and 4t + 3 for t = 2, 3. So the rows of B that it meets belong to a lane
// each: 0, 2, 1 and 3. These lanes' other registers of B meet nothing, and may hold anything.
struct F16Sparse : F16 {
    static constexpr uint32_t COLUMNS = 0xee44ee44;

    static __device__ __forceinline__ int rows_of_b(int t) { return (t & 1) << 1 | t >> 1; }
    static __device__ __forceinline__ void multiply(float (&d)[4], Pair upper, Pair lower, Pair b, const float (&c)[4]) {
        const uint32_t rows[2] = {upper, lower};
        const uint32_t column[2] = {b, b};
        mma_sp_m16n8k16_f16(d, rows, column, c, COLUMNS);
    }
};

// tf32's lanes hold k = t and t + 4. Any order of k will do, if A and B have the same: 2t counts as t, 2t + 1 as t + 4.
struct Tf32 {
    struct Pair {
        uint32_t even, odd;
    };
    // It has the exponents of f32.
    static constexpr bool SCALED = false;

    static __device__ __forceinline__ int rows_of_b(int t) { return t; }
    static __device__ __forceinline__ Pair zero() { return {0, 0}; }
    static __device__ __forceinline__ Pair round(float2 x) { return {to_tf32(x.x), to_tf32(x.y)}; }
    static __device__ __forceinline__ float2 value(Pair p) {
        // PTX does not say what the conversion leaves in the lowest 13 bits.
        return make_float2(__uint_as_float(p.even & 0xffffe000u), __uint_as_float(p.odd & 0xffffe000u));
    }
    static __device__ __forceinline__ void multiply(float (&d)[4], Pair upper, Pair lower, Pair b, const float (&c)[4]) {
        const uint32_t rows[4] = {upper.even, lower.even, upper.odd, lower.odd};
        const uint32_t column[2] = {b.even, b.odd};
        mma_m16n8k8_tf32(d, rows, column, c);
    }
};

// Two numbers as their roundings and, with recovery, the roundings of the rest.
template <class Format> struct Split {
    typename Format::Pair high, low;
};

template <class Format, bool RECOVERED> static __device__ __forceinline__ Split<Format> split(float2 x) {
    Split<Format> s = {Format::round(x), Format::zero()};
    if (RECOVERED) {
        const float2 high = Format::value(s.high);
        s.low = Format::round(make_float2(x.x - high.x, x.y - high.y));
    }
    return s;
}

// [upper; lower] B at row g and columns 2t and 2t + 1: d[0], d[1] of `upper`, d[2], d[3] of `lower`.
template <class Format, bool RECOVERED>
static __device__ __forceinline__ void multiply(float (&d)[4], const Split<Format> &upper, const Split<Format> &lower,
                                                const Split<Format> &b) {
    const float zero[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    if (RECOVERED) {
        // Smallest first, in one accumulator: to sum the largest apart takes registers, and changed next to nothing.
        Format::multiply(d, upper.low, lower.low, b.high, zero);
        Format::multiply(d, upper.high, lower.high, b.low, d);
        Format::multiply(d, upper.high, lower.high, b.high, d);
    } else {
        Format::multiply(d, upper.high, lower.high, b.high, zero);
    }
}

// What Bernstein values are multiplied by in f16.
constexpr float BASIS_SCALE = 512.0f;

// Elements 2t and 2t + 1 of a line of Bernstein values or derivatives, times a scale where the format has few exponents.
template <class Format>
static __device__ __forceinline__ float2 load_pair(Buffer<const float> line, int degree, int t, float scale_if_needed) {
    const float scale = Format::SCALED ? scale_if_needed : 1.0f;
    const float even = 2 * t <= degree ? __ldg(line + 2 * t) : 0.0f;
    const float odd = 2 * t + 1 <= degree ? __ldg(line + 2 * t + 1) : 0.0f;
    return make_float2(even * scale, odd * scale);
}

// Brings what the net's largest coordinate is just below 2^6, and takes this and the two factors 2^9 of Bernstein values away.
struct Scale {
    float apply = 1.0f, undo = 1.0f;
};

// `largest`: of the lane's coordinates, by magnitude. Numbers below 2^-103 count as that, so that both are normal.
static __device__ __forceinline__ Scale scale_of(float largest) {
    const uint32_t exponent = max(__reduce_max_sync(0xffffffffu, __float_as_uint(largest)) >> 23, 24u);
    return {__uint_as_float((259u - exponent) << 23), __uint_as_float((exponent - 23u) << 23)};
}

// Of the points 2t and 2t + 1 of column g: x and y together, z, w.
static __device__ __forceinline__ void scales_of(Scale (&scales)[4], float4 a, float4 b) {
    scales[0] = scale_of(fmaxf(fmaxf(fabsf(a.x), fabsf(b.x)), fmaxf(fabsf(a.y), fabsf(b.y))));
    scales[1] = scales[0];
    scales[2] = scale_of(fmaxf(fabsf(a.z), fabsf(b.z)));
    scales[3] = scale_of(fmaxf(fabsf(a.w), fabsf(b.w)));
}

static __device__ __forceinline__ float4 load_point(Buffer<const float4> net, const int (&degree)[2], int row, int column) {
    if (row > degree[0] || column > degree[1]) {
        return make_float4(0.0f, 0.0f, 0.0f, 0.0f);
    }
    return __ldg(net + row * (degree[1] + 1) + column);
}

} // namespace tensor
