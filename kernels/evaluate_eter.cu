// ETER's kernel without tensor cores, the baseline of its table 1 (section 5.2: shared memory, coalesced accesses, no bank
// conflicts, persistent threads): points and normals of meshlets, degrees 1 to 7.
//
// A thread a vertex, 64 a meshlet. Net and Bernstein values lie in shared memory, and each vertex sums all of the net: the
// time grows with the square of the degree, as ETER's does. Bernstein values come from tables; ETER computes two a thread.
#include "surface.cuh"

namespace eter {

using namespace surface;

constexpr int SIDE = int(MESHLET_VERTICES);
constexpr int VERTICES = SIDE * SIDE;
constexpr int THREADS = WARPS * 32;
constexpr int MESHLETS = THREADS / VERTICES;
// Floats from line to line: eight lines in eight banks.
constexpr int PITCH = SIDE + 1;

// One meshlet's: Bernstein values of its lines in u and v, and their derivatives.
struct Lines {
    Span<float> u, slope_u, v, slope_v;
};

// Thread k loads control point k and element k % 8 of line k / 8.
static __device__ __forceinline__ void stage(const Buffers &in, const Patch &patch, const Meshlet &m, Span<float4> net,
                                             const Lines &lines, int k) {
    const int degree[2] = {int(patch.degree[0]), int(patch.degree[1])};
    if (k < (degree[0] + 1) * (degree[1] + 1)) {
        net[k] = __ldg(as<const float4>(in.nets + patch.net) + k);
    }
    const int line = k / SIDE;
    const int i = k % SIDE;
    if (i <= degree[0] && line <= m.quads[0]) {
        const uint32_t at = patch.basis[0] + (m.first[0] + line) * (degree[0] + 1) + i;
        lines.u[line * PITCH + i] = __ldg(in.basis + at);
        lines.slope_u[line * PITCH + i] = __ldg(in.slopes + at);
    }
    if (i <= degree[1] && line <= m.quads[1]) {
        const uint32_t at = patch.basis[1] + (m.first[1] + line) * (degree[1] + 1) + i;
        lines.v[line * PITCH + i] = __ldg(in.basis + at);
        lines.slope_v[line * PITCH + i] = __ldg(in.slopes + at);
    }
}

// DEGREE: of both directions; 0: any.
template <int DEGREE>
static __device__ __forceinline__ Sums sum(const Patch &patch, Span<float4> net, const Lines &lines, int row, int column) {
    const int degree_u = DEGREE > 0 ? DEGREE : int(patch.degree[0]);
    const int degree_v = DEGREE > 0 ? DEGREE : int(patch.degree[1]);
    Sums sums = {zero4(), zero4(), zero4()};
#pragma unroll (DEGREE > 0 ? DEGREE + 1 : 1)
    for (int j = 0; j <= degree_v; j++) {
        float4 value = zero4(), slope = zero4();
#pragma unroll (DEGREE > 0 ? DEGREE + 1 : 4)
        for (int i = 0; i <= degree_u; i++) {
            const float4 c = net[i * (degree_v + 1) + j];
            add_scaled(value, c, lines.u[row * PITCH + i]);
            add_scaled(slope, c, lines.slope_u[row * PITCH + i]);
        }
        const float b = lines.v[column * PITCH + j];
        add_scaled(sums.point, value, b);
        add_scaled(sums.along_u, slope, b);
        add_scaled(sums.along_v, value, lines.slope_v[column * PITCH + j]);
    }
    return sums;
}

template <int DEGREE>
static __device__ __forceinline__ void evaluate(const Buffers &in, Buffer<SurfacePoint> points, uint32_t count) {
    SHARED(float4, nets, [MESHLETS][VERTICES]);
    SHARED(float, tables, [MESHLETS][4][SIDE * PITCH]);
    const int mine = int(threadIdx.x) / VERTICES;
    const int k = int(threadIdx.x) % VERTICES;
    const Lines lines = {tables[mine][0], tables[mine][1], tables[mine][2], tables[mine][3]};
    for (uint32_t first = blockIdx.x * MESHLETS; first < count; first += gridDim.x * MESHLETS) {
        const bool inside = first + mine < count;
        Meshlet m = {};
        Patch patch = {};
        if (inside) {
            m = in.meshlets[first + mine];
            patch = in.patches[m.patch];
            stage(in, patch, m, nets[mine], lines, k);
        }
        __syncthreads();
        const int row = k / SIDE;
        const int column = k % SIDE;
        if (inside && row <= m.quads[0] && column <= m.quads[1]) {
            const Sums sums = sum<DEGREE>(patch, nets[mine], lines, row, column);
            store(points + m.vertices + row * (m.quads[1] + 1) + column, sums);
        }
        // The next meshlet overwrites these.
        __syncthreads();
    }
}

} // namespace eter

// As many blocks as fit on the device at once, or fewer.
SURFACE_KERNEL(evaluate_eter, SurfacePoint, eter::evaluate<0>)
SURFACE_KERNEL(evaluate_eter_d3, SurfacePoint, eter::evaluate<3>)
SURFACE_KERNEL(evaluate_eter_d4, SurfacePoint, eter::evaluate<4>)
SURFACE_KERNEL(evaluate_eter_d5, SurfacePoint, eter::evaluate<5>)
SURFACE_KERNEL(evaluate_eter_d6, SurfacePoint, eter::evaluate<6>)
SURFACE_KERNEL(evaluate_eter_d7, SurfacePoint, eter::evaluate<7>)
