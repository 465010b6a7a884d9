// Points with normals, or with both tangents too, in f32 by FMA: evaluate.cu's way through a meshlet, with the derivatives of
// the Bernstein values beside them. For `bench evaluate`; frames take normals a pixel, in shade.cu.
#include "surface.cuh"

namespace evaluate_normals {

using namespace surface;

// Columns of the net a warp sums at once: 32 lanes, eight rows.
constexpr int COLUMNS = 4;

// Sums over u of columns of the net, for eight rows each: of Bernstein values, of derivatives.
struct Columns {
    Span<float4> values, slopes;
};

// DEGREE > 0: of both directions; 0: any degrees, read from the patch.
template <int DEGREE>
static __device__ __forceinline__ void sum_over_u(const Columns &columns, int place, Buffer<const float4> net, int stride,
                                                  Buffer<const float> basis, Buffer<const float> slopes, int degree) {
    float4 value = zero4(), slope = zero4();
#pragma unroll (DEGREE > 0 ? DEGREE + 1 : 4)
    for (int r = 0; r <= (DEGREE > 0 ? DEGREE : degree); r++) {
        const float4 c = __ldg(net + r * stride);
        add_scaled(value, c, __ldg(basis + r));
        add_scaled(slope, c, __ldg(slopes + r));
    }
    columns.values[place] = value;
    columns.slopes[place] = slope;
}

static __device__ __forceinline__ void add_column(Sums &sums, float4 value, float4 slope, float b, float d) {
    add_scaled(sums.point, value, b);
    add_scaled(sums.along_u, slope, b);
    add_scaled(sums.along_v, value, d);
}

template <int DEGREE, class Output>
static __device__ __forceinline__ void meshlet(const Buffers &in, Buffer<Output> points, const Meshlet &m,
                                               const Columns &columns, int lane) {
    const Patch patch = in.patches[m.patch];
    const int degree_u = DEGREE > 0 ? DEGREE : int(patch.degree[0]);
    const int degree_v = DEGREE > 0 ? DEGREE : int(patch.degree[1]);
    const int across = lane & 7;
    const int down = lane >> 3;
    // Lanes beyond a small meshlet do as its last row and column; they store nothing.
    const uint32_t line_u = patch.basis[0] + (m.first[0] + min(across, int(m.quads[0]))) * (degree_u + 1);
    const uint32_t line_v = patch.basis[1] + (m.first[1] + min(across, int(m.quads[1]))) * (degree_v + 1);
    const Buffer<const float4> net = as<const float4>(in.nets + patch.net);

    Sums low = {zero4(), zero4(), zero4()};
    Sums high = low;
#pragma unroll (DEGREE > 0 ? 2 : 1)
    for (int first = 0; first <= degree_v; first += COLUMNS) {
        if (first + down <= degree_v) {
            sum_over_u<DEGREE>(columns, down * 8 + across, net + first + down, degree_v + 1, in.basis + line_u,
                               in.slopes + line_u, degree_u);
        }
        __syncwarp();
#pragma unroll
        for (int k = 0; k < COLUMNS; k++) {
            if (first + k <= degree_v) {
                const float b = __ldg(in.basis + line_v + first + k);
                const float d = __ldg(in.slopes + line_v + first + k);
                add_column(low, columns.values[k * 8 + down], columns.slopes[k * 8 + down], b, d);
                add_column(high, columns.values[k * 8 + down + 4], columns.slopes[k * 8 + down + 4], b, d);
            }
        }
        // The next four columns overwrite these.
        __syncwarp();
    }

    const Buffer<Output> to = points + m.vertices + across;
    const int pitch = m.quads[1] + 1;
    if (across <= m.quads[1] && down <= m.quads[0]) {
        store(to + down * pitch, low);
    }
    if (across <= m.quads[1] && down + 4 <= m.quads[0]) {
        store(to + (down + 4) * pitch, high);
    }
}

template <int DEGREE, class Output>
static __device__ __forceinline__ void evaluate(const Buffers &in, Buffer<Output> points, uint32_t count) {
    SHARED(float4, values, [WARPS][COLUMNS * 8]);
    SHARED(float4, slopes, [WARPS][COLUMNS * 8]);
    const uint32_t warp = threadIdx.x / 32;
    const uint32_t number = blockIdx.x * WARPS + warp;
    if (number < count) {
        const Meshlet m = in.meshlets[number];
        meshlet<DEGREE>(in, points, m, {values[warp], slopes[warp]}, int(threadIdx.x % 32));
    }
}

} // namespace evaluate_normals

// Grids of ceil(count / 4) blocks.
SURFACE_KERNEL(evaluate_normals_f32, SurfacePoint, evaluate_normals::evaluate<0>)
SURFACE_KERNEL(evaluate_normals_f32_d3, SurfacePoint, evaluate_normals::evaluate<3>)
SURFACE_KERNEL(evaluate_normals_f32_d4, SurfacePoint, evaluate_normals::evaluate<4>)
SURFACE_KERNEL(evaluate_normals_f32_d5, SurfacePoint, evaluate_normals::evaluate<5>)
SURFACE_KERNEL(evaluate_normals_f32_d6, SurfacePoint, evaluate_normals::evaluate<6>)
SURFACE_KERNEL(evaluate_normals_f32_d7, SurfacePoint, evaluate_normals::evaluate<7>)
SURFACE_KERNEL(evaluate_tangents_f32, SurfaceFrame, evaluate_normals::evaluate<0>)
