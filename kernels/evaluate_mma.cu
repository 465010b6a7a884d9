// evaluate on tensor cores: what evaluate_f32 does, for degrees 1 to 7. Higher degrees are for evaluate_f32.
//
// One warp a meshlet. Lane l is (g, t) = (l / 4, l % 4). Two chained products a coordinate c of the homogeneous net:
//   T[c] = B_u C[c]                 B_u: Bernstein values, a row a line of the grid; C[c]: the net, a row a value of u
//   [S[x]; S[y]] = [T[x]; T[y]] B_v'   two coordinates at once, and so z and w
// mma.sync hands out D as it wants A, so nothing moves between lanes: the second product's A is the first one's D, rounded.
// Net and Bernstein values are padded with zeros to degree 7, so one kernel does all degrees.
//
// Recovery (Ootomo and Yokota, "Recovering single precision accuracy from Tensor Cores", 2022): x = high + low, each of 11
// bits, and (a + b)(c + d) without its smallest term. Two things are done differently:
// - f16's low parts are not multiplied by 2^11 but kept off the subnormal numbers by where the high ones lie: the largest
//   coordinate of the net just below 2^6, Bernstein values times 2^9, so that T stays below 2^15. All are powers of two,
//   undone in f32, so only a low part of less than 2^-31 of its largest loses bits. Then the products need no merging.
// - The first product has eight rows to spare in A: they take the low parts of B_u, and two mma.sync do for three.
// Costs and measured errors: bench/results/evaluate-precisions.md.
#include "evaluate.cuh"

namespace evaluate_mma {

using evaluate::Buffers;
using evaluate::WARPS;

// Elements 2t and 2t + 1 of a row of A or a column of B.
struct F16 {
    using Pair = uint32_t;
    static constexpr bool SCALED = true;

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

// tf32's lanes hold k = t and t + 4. Any order of k will do, if A and B have the same: 2t counts as t, 2t + 1 as t + 4.
struct Tf32 {
    struct Pair {
        uint32_t even, odd;
    };
    // It has the exponents of f32.
    static constexpr bool SCALED = false;

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

// Row g of B_u C at columns 2t and 2t + 1.
template <class Format, bool RECOVERED>
static __device__ __forceinline__ float2 sum_over_u(const Split<Format> &basis, const Split<Format> &net) {
    const float zero[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    float d[4];
    if (!RECOVERED) {
        Format::multiply(d, basis.high, Format::zero(), net.high, zero);
        return make_float2(d[0], d[1]);
    }
    // The low parts' rows are summed apart and join last, rounded to nearest.
    Format::multiply(d, basis.high, basis.low, net.low, zero);
    Format::multiply(d, basis.high, basis.low, net.high, d);
    return make_float2(d[0] + d[2], d[1] + d[3]);
}

// Row g of two coordinates at the lane's two vertices: d[0], d[1] of the first, d[2], d[3] of the second.
template <class Format, bool RECOVERED>
static __device__ __forceinline__ void sum_over_v(float (&d)[4], const Split<Format> &first, const Split<Format> &second,
                                                  const Split<Format> &basis) {
    const float zero[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    if (RECOVERED) {
        // Smallest first, in one accumulator: to sum the largest apart takes registers, and changed next to nothing.
        Format::multiply(d, first.low, second.low, basis.high, zero);
        Format::multiply(d, first.high, second.high, basis.low, d);
        Format::multiply(d, first.high, second.high, basis.high, d);
    } else {
        Format::multiply(d, first.high, second.high, basis.high, zero);
    }
}

// Bernstein values 2t and 2t + 1 of a line of the grid.
template <class Format>
static __device__ __forceinline__ float2 load_basis(Buffer<const float> line, int degree, int t) {
    const float scale = Format::SCALED ? 512.0f : 1.0f;
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

template <class Format, bool RECOVERED>
static __device__ __forceinline__ void meshlet(const View &view, const Buffers &in, const Meshlet &m, int lane) {
    const Patch patch = in.patches[m.patch];
    const int degree[2] = {int(patch.degree[0]), int(patch.degree[1])};
    const int g = lane >> 2;
    const int t = lane & 3;
    // Column n of D is the grid's line n / 2 + 4 (n % 2): lanes then have lines t and t + 4, and four neighbours store 64
    // bytes in a row. Lanes beyond a small meshlet do as its last row and column; they store nothing.
    const int row = m.first[0] + min(g, int(m.quads[0]));
    const int line = m.first[1] + min((g >> 1) + 4 * (g & 1), int(m.quads[1]));
    const Split<Format> basis_u = split<Format, RECOVERED>(
        load_basis<Format>(in.basis + patch.basis[0] + row * (degree[0] + 1), degree[0], t));
    const Split<Format> basis_v = split<Format, RECOVERED>(
        load_basis<Format>(in.basis + patch.basis[1] + line * (degree[1] + 1), degree[1], t));
    const Buffer<const float4> net = as<const float4>(in.nets + patch.net);
    const float4 even = load_point(net, degree, 2 * t, g);
    const float4 odd = load_point(net, degree, 2 * t + 1, g);

    Scale scales[4];
    if (Format::SCALED) {
        scales_of(scales, even, odd);
    }
    const float2 columns[4] = {make_float2(even.x, odd.x), make_float2(even.y, odd.y), make_float2(even.z, odd.z),
                               make_float2(even.w, odd.w)};
    Split<Format> sums[4];
#pragma unroll
    for (int c = 0; c < 4; c++) {
        const float2 scaled = make_float2(columns[c].x * scales[c].apply, columns[c].y * scales[c].apply);
        sums[c] = split<Format, RECOVERED>(
            sum_over_u<Format, RECOVERED>(basis_u, split<Format, RECOVERED>(scaled)));
    }
    float xy[4], zw[4];
    sum_over_v<Format, RECOVERED>(xy, sums[0], sums[1], basis_v);
    sum_over_v<Format, RECOVERED>(zw, sums[2], sums[3], basis_v);

    const Buffer<Vertex> vertices = in.vertices + m.vertices + g * (m.quads[1] + 1);
#pragma unroll
    for (int k = 0; k < 2; k++) {
        if (g <= m.quads[0] && t + 4 * k <= m.quads[1]) {
            const float4 point = make_float4(xy[k] * scales[0].undo, xy[k + 2] * scales[1].undo, zw[k] * scales[2].undo,
                                             zw[k + 2] * scales[3].undo);
            vertices[t + 4 * k] = evaluate::project(view, patch, point);
        }
    }
}

template <class Format, bool RECOVERED>
static __device__ __forceinline__ void evaluate_meshlet(const View &view, const Buffers &in, uint32_t count) {
    const uint32_t number = blockIdx.x * WARPS + threadIdx.x / 32;
    // The same for all lanes of a warp, as mma.sync needs.
    if (number < count) {
        const Meshlet m = in.meshlets[number];
        meshlet<Format, RECOVERED>(view, in, m, int(threadIdx.x % 32));
    }
}

} // namespace evaluate_mma

// A grid of ceil(count / 4) blocks.
#define EVALUATE_MMA(name, FORMAT, RECOVERED)                                                                          \
    extern "C" __global__ void __launch_bounds__(evaluate::WARPS * 32)                                                 \
        name(const __grid_constant__ View view, Buffer<const Patch> patches, Buffer<const Meshlet> meshlets,           \
             Buffer<const Point> nets, Buffer<const float> basis, Buffer<Vertex> vertices, uint32_t count) {           \
        evaluate_mma::evaluate_meshlet<evaluate_mma::FORMAT, RECOVERED>(                                               \
            view, {patches, meshlets, nets, basis, vertices}, count);                                                  \
    }                                                                                                                  \
    KERNEL(name)

EVALUATE_MMA(evaluate_f16, F16, false)
EVALUATE_MMA(evaluate_f16_recovered, F16, true)
EVALUATE_MMA(evaluate_tf32, Tf32, false)
EVALUATE_MMA(evaluate_tf32_recovered, Tf32, true)
