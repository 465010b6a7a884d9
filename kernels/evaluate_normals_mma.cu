// Points with normals, or with both tangents too, on tensor cores, for degrees 1 to 7: ETER section 5.1, with the spare half
// of A for derivatives. One warp a meshlet, ten products without recovery (ETER takes twelve); C[c]: a coordinate of the net.
//   [T[c]; T_u[c]] = [B_u; B_u'] C[c]                four products
//   [S[c]; S_u[c]] = [T[c]; T_u[c]] B_v              four
//   [S_v[x]; S_v[y]] = [T[x]; T[y]] B_v'             two coordinates at once: two
// With recovery each is three. How f16 is scaled: evaluate_mma.cu. Derivatives are up to 14 times as large, so their scale
// is 2^5, and T_u stays below 2^15 as T does.
#include "surface.cuh"
#include "tensor.cuh"

namespace evaluate_normals_mma {

using namespace surface;
using namespace tensor;

constexpr float SLOPE_SCALE = 32.0f;
// What is left to undo of a derivative, once 2^9 has been for each Bernstein factor.
constexpr float SLOPE_UNDO = BASIS_SCALE / SLOPE_SCALE;

// What a lane multiplies by: of its row in u and of its column of B in v.
template <class Format> struct Bases {
    Split<Format> u, slope_u, v, slope_v;
};

template <class Format, bool RECOVERED>
static __device__ __forceinline__ Bases<Format> load_bases(const Buffers &in, const Patch &patch, const Meshlet &m, int g,
                                                           int t) {
    const int degree[2] = {int(patch.degree[0]), int(patch.degree[1])};
    // As in evaluate_mma.cu: lanes get the lines t and t + 4.
    const int row = m.first[0] + min(g, int(m.quads[0]));
    const int line = m.first[1] + min((g >> 1) + 4 * (g & 1), int(m.quads[1]));
    const uint32_t at_u = patch.basis[0] + row * (degree[0] + 1);
    const int b = Format::rows_of_b(t);
    const uint32_t at_v = patch.basis[1] + line * (degree[1] + 1);
    return {split<Format, RECOVERED>(load_pair<Format>(in.basis + at_u, degree[0], t, BASIS_SCALE)),
            split<Format, RECOVERED>(load_pair<Format>(in.slopes + at_u, degree[0], t, SLOPE_SCALE)),
            split<Format, RECOVERED>(load_pair<Format>(in.basis + at_v, degree[1], b, BASIS_SCALE)),
            split<Format, RECOVERED>(load_pair<Format>(in.slopes + at_v, degree[1], b, SLOPE_SCALE))};
}

// Of the lane's vertex k: x, y, z and w of S, S_u and S_v.
template <bool SCALED>
static __device__ __forceinline__ Sums sums_of(const float (&s)[4][4], const float (&v)[2][4], const Scale (&scales)[4],
                                               int k) {
    float4 undo = make_float4(1.0f, 1.0f, 1.0f, 1.0f);
    float slope = 1.0f;
    if (SCALED) {
        undo = make_float4(scales[0].undo, scales[1].undo, scales[2].undo, scales[3].undo);
        slope = SLOPE_UNDO;
    }
    const auto times = [&undo](float x, float y, float z, float w, float more) {
        return make_float4(x * undo.x * more, y * undo.y * more, z * undo.z * more, w * undo.w * more);
    };
    return {times(s[0][k], s[1][k], s[2][k], s[3][k], 1.0f), times(s[0][k + 2], s[1][k + 2], s[2][k + 2], s[3][k + 2], slope),
            times(v[0][k], v[0][k + 2], v[1][k], v[1][k + 2], slope)};
}

template <class Format, bool RECOVERED, class Output>
static __device__ __forceinline__ void meshlet(const Buffers &in, Buffer<Output> points, const Meshlet &m, int lane) {
    const Patch patch = in.patches[m.patch];
    const int degree[2] = {int(patch.degree[0]), int(patch.degree[1])};
    const int g = lane >> 2;
    const int t = lane & 3;
    const Bases<Format> bases = load_bases<Format, RECOVERED>(in, patch, m, g, t);
    const Buffer<const float4> net = as<const float4>(in.nets + patch.net);
    const int b = Format::rows_of_b(t);
    const float4 even = load_point(net, degree, 2 * b, g);
    const float4 odd = load_point(net, degree, 2 * b + 1, g);
    Scale scales[4];
    if (Format::SCALED) {
        scales_of(scales, even, odd);
    }
    const float2 columns[4] = {make_float2(even.x, odd.x), make_float2(even.y, odd.y), make_float2(even.z, odd.z),
                               make_float2(even.w, odd.w)};

    Split<Format> over_u[4];
    float s[4][4], v[2][4];
#pragma unroll
    for (int c = 0; c < 4; c++) {
        const float2 scaled = make_float2(columns[c].x * scales[c].apply, columns[c].y * scales[c].apply);
        float d[4];
        multiply<Format, RECOVERED>(d, bases.u, bases.slope_u, split<Format, RECOVERED>(scaled));
        over_u[c] = split<Format, RECOVERED>(make_float2(d[0], d[1]));
        multiply<Format, RECOVERED>(s[c], over_u[c], split<Format, RECOVERED>(make_float2(d[2], d[3])), bases.v);
    }
    multiply<Format, RECOVERED>(v[0], over_u[0], over_u[1], bases.slope_v);
    multiply<Format, RECOVERED>(v[1], over_u[2], over_u[3], bases.slope_v);

    const Buffer<Output> to = points + m.vertices + g * (m.quads[1] + 1);
#pragma unroll
    for (int k = 0; k < 2; k++) {
        if (g <= m.quads[0] && t + 4 * k <= m.quads[1]) {
            store(to + (t + 4 * k), sums_of<Format::SCALED>(s, v, scales, k));
        }
    }
}

template <class Format, bool RECOVERED, class Output>
static __device__ __forceinline__ void evaluate(const Buffers &in, Buffer<Output> points, uint32_t count) {
    const uint32_t number = blockIdx.x * WARPS + threadIdx.x / 32;
    // The same for all lanes of a warp, as mma.sync needs.
    if (number < count) {
        const Meshlet m = in.meshlets[number];
        meshlet<Format, RECOVERED>(in, points, m, int(threadIdx.x % 32));
    }
}

} // namespace evaluate_normals_mma

// Grids of ceil(count / 4) blocks.
SURFACE_KERNEL(evaluate_normals_f16, SurfacePoint, evaluate_normals_mma::evaluate<tensor::F16, false>)
SURFACE_KERNEL(evaluate_normals_f16_recovered, SurfacePoint, evaluate_normals_mma::evaluate<tensor::F16, true>)
SURFACE_KERNEL(evaluate_normals_f16_sparse, SurfacePoint, evaluate_normals_mma::evaluate<tensor::F16Sparse, false>)
SURFACE_KERNEL(evaluate_normals_tf32, SurfacePoint, evaluate_normals_mma::evaluate<tensor::Tf32, false>)
SURFACE_KERNEL(evaluate_normals_tf32_recovered, SurfacePoint, evaluate_normals_mma::evaluate<tensor::Tf32, true>)
SURFACE_KERNEL(evaluate_tangents_f16_recovered, SurfaceFrame, evaluate_normals_mma::evaluate<tensor::F16, true>)
