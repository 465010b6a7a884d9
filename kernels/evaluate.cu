// evaluate: the vertices of every meshlet, written to memory (the staged frame). Twin of src/stages/evaluate.rs.
//
// f32 with the CPU's own operations in the CPU's own order, so that both frames have the same words: products are summed
// unfused, in index order. The arithmetic hides behind the stores (1 KB a full meshlet), and what Horner's scheme with
// FMA would save is not worth two sets of words. Bernstein values come from tables rounded once from f64.
//
// One warp a meshlet. Four columns of the net at a time are summed over u for all eight rows of vertices (lane = column,
// row) and handed over through shared memory to the lanes that sum them over v (lane = row, column of vertices; two
// vertices a lane). Any degree takes 512 bytes a warp.
#include "evaluate.cuh"

namespace evaluate {

// Columns of the net a warp sums at once: 32 lanes, eight rows.
constexpr int COLUMNS = 4;

// The sum over u of one column of the net, at the grid line whose Bernstein values are `basis`.
template <int DEGREE>
static __device__ __forceinline__ float4 sum_over_u(Buffer<const float4> column, int stride, Buffer<const float> basis,
                                                    int degree) {
    float4 sum = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
#pragma unroll (DEGREE > 0 ? DEGREE + 1 : 4)
    for (int r = 0; r <= (DEGREE > 0 ? DEGREE : degree); r++) {
        sum = add_scaled(sum, __ldg(column + r * stride), __ldg(basis + r));
    }
    return sum;
}

// DEGREE > 0: of both directions; 0: any degrees, read from the patch.
template <int DEGREE>
static __device__ __forceinline__ void meshlet(const View &view, const Buffers &in, const Meshlet &m, Span<float4> columns,
                                               int lane) {
    const Patch patch = in.patches[m.patch];
    const int degree_u = DEGREE > 0 ? DEGREE : int(patch.degree[0]);
    const int degree_v = DEGREE > 0 ? DEGREE : int(patch.degree[1]);
    const int across = lane & 7;
    const int down = lane >> 3;
    // Lanes beyond a small meshlet do as its last row and column; they store nothing.
    const int row = min(across, int(m.quads[0]));
    const int line = min(across, int(m.quads[1]));
    const Buffer<const float> basis_u = in.basis + patch.basis[0] + (m.first[0] + row) * (degree_u + 1);
    const Buffer<const float> basis_v = in.basis + patch.basis[1] + (m.first[1] + line) * (degree_v + 1);
    const Buffer<const float4> net = as<const float4>(in.nets + patch.net);

    float4 low = make_float4(0.0f, 0.0f, 0.0f, 0.0f);
    float4 high = low;
#pragma unroll (DEGREE > 0 ? 2 : 1)
    for (int first = 0; first <= degree_v; first += COLUMNS) {
        if (first + down <= degree_v) {
            columns[down * 8 + across] =
                sum_over_u<DEGREE>(net + first + down, degree_v + 1, basis_u, degree_u);
        }
        __syncwarp();
#pragma unroll
        for (int k = 0; k < COLUMNS; k++) {
            if (first + k <= degree_v) {
                const float b = __ldg(basis_v + first + k);
                low = add_scaled(low, columns[k * 8 + down], b);
                high = add_scaled(high, columns[k * 8 + down + 4], b);
            }
        }
        // The next four columns overwrite these.
        __syncwarp();
    }

    const Buffer<Vertex> vertices = in.vertices + m.vertices + across;
    const int pitch = m.quads[1] + 1;
    if (across <= m.quads[1] && down <= m.quads[0]) {
        vertices[down * pitch] = project(view, patch, low);
    }
    if (across <= m.quads[1] && down + 4 <= m.quads[0]) {
        vertices[(down + 4) * pitch] = project(view, patch, high);
    }
}

template <int DEGREE>
static __device__ __forceinline__ void evaluate(const View &view, const Buffers &in, const Count &count) {
    SHARED(float4, columns, [WARPS][COLUMNS * 8]);
    const uint32_t warp = threadIdx.x / 32;
    const uint32_t number = blockIdx.x * WARPS + warp;
    if (number < count.get()) {
        const Meshlet m = in.meshlets[number];
        meshlet<DEGREE>(view, in, m, columns[warp], int(threadIdx.x % 32));
    }
}

} // namespace evaluate

// A grid of ceil(room / 4) blocks.
#define EVALUATE(name, DEGREE)                                                                                         \
    extern "C" __global__ void __launch_bounds__(evaluate::WARPS * 32)                                                 \
        name(const __grid_constant__ View view, Buffer<const Patch> patches, Buffer<const Meshlet> meshlets,           \
             Buffer<const Point> nets, Buffer<const float> basis, Buffer<Vertex> vertices, Count count) {           \
        evaluate::evaluate<DEGREE>(view, {patches, meshlets, nets, basis, vertices}, count);                           \
    }                                                                                                                  \
    KERNEL(name)

// Any degrees, also different ones in u and v.
EVALUATE(evaluate_f32, 0)
// The same degree in u and v: loops unrolled.
EVALUATE(evaluate_f32_d1, 1)
EVALUATE(evaluate_f32_d2, 2)
EVALUATE(evaluate_f32_d3, 3)
EVALUATE(evaluate_f32_d4, 4)
EVALUATE(evaluate_f32_d5, 5)
EVALUATE(evaluate_f32_d6, 6)
EVALUATE(evaluate_f32_d7, 7)
