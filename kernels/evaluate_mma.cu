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
#include "tensor.cuh"

namespace evaluate_mma {

using evaluate::Buffers;
using evaluate::WARPS;
using namespace tensor;

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

template <class Format, bool RECOVERED>
static __device__ __forceinline__ void meshlet(const View &view, const Buffers &in, const Meshlet &m, int lane) {
    const Patch patch = in.patches[m.patch];
    const int degree[2] = {int(patch.degree[0]), int(patch.degree[1])};
    const int g = lane >> 2;
    const int t = lane & 3;
    const int b = Format::rows_of_b(t);
    // Column n of D is the grid's line n / 2 + 4 (n % 2): lanes then have lines t and t + 4, and four neighbours store 64
    // bytes in a row. Lanes beyond a small meshlet do as its last row and column; they store nothing.
    const int row = m.first[0] + min(g, int(m.quads[0]));
    const int line = m.first[1] + min((g >> 1) + 4 * (g & 1), int(m.quads[1]));
    const Split<Format> basis_u = split<Format, RECOVERED>(
        load_pair<Format>(in.basis + patch.basis[0] + row * (degree[0] + 1), degree[0], t, BASIS_SCALE));
    const Split<Format> basis_v = split<Format, RECOVERED>(
        load_pair<Format>(in.basis + patch.basis[1] + line * (degree[1] + 1), degree[1], b, BASIS_SCALE));
    const Buffer<const float4> net = as<const float4>(in.nets + patch.net);
    const float4 even = load_point(net, degree, 2 * b, g);
    const float4 odd = load_point(net, degree, 2 * b + 1, g);

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
    multiply<Format, RECOVERED>(xy, sums[0], sums[1], basis_v);
    multiply<Format, RECOVERED>(zw, sums[2], sums[3], basis_v);

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
static __device__ __forceinline__ void evaluate_meshlet(const View &view, const Buffers &in, const Count &count) {
    const uint32_t number = blockIdx.x * WARPS + threadIdx.x / 32;
    // The same for all lanes of a warp, as mma.sync needs.
    if (number < count.get()) {
        const Meshlet m = in.meshlets[number];
        meshlet<Format, RECOVERED>(view, in, m, int(threadIdx.x % 32));
    }
}

} // namespace evaluate_mma

// A grid of ceil(room / 4) blocks.
#define EVALUATE_MMA(name, FORMAT, RECOVERED)                                                                          \
    extern "C" __global__ void __launch_bounds__(evaluate::WARPS * 32)                                                 \
        name(const __grid_constant__ View view, Buffer<const Patch> patches, Buffer<const Meshlet> meshlets,           \
             Buffer<const Point> nets, Buffer<const float> basis, Buffer<Vertex> vertices, Count count) {           \
        evaluate_mma::evaluate_meshlet<tensor::FORMAT, RECOVERED>(                                               \
            view, {patches, meshlets, nets, basis, vertices}, count);                                                  \
    }                                                                                                                  \
    KERNEL(name)

EVALUATE_MMA(evaluate_f16, F16, false)
EVALUATE_MMA(evaluate_f16_recovered, F16, true)
EVALUATE_MMA(evaluate_f16_sparse, F16Sparse, false)
EVALUATE_MMA(evaluate_tf32, Tf32, false)
EVALUATE_MMA(evaluate_tf32_recovered, Tf32, true)
