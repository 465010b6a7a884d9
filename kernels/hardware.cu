// rasterize by hardware: which meshlets go there, and which workgroups of mesh shaders draw them (ETER section 6.2). Twin of
// src/stages/hardware.rs and src/vulkan/jobs.rs.
#include "patch_point.cuh"

namespace hardware {

// Items of a meshlet that one workgroup of vk_shaders/outlines.mesh looks at.
constexpr uint32_t ITEMS = 32;
// `Kind` of src/vulkan/pipeline.rs. Bins are kinds, each without trims and with them.
enum Kind : uint32_t { FAR, BORDERS, FOLDS, TURNED_AWAY, CONSERVATIVE, TRIANGLES, KINDS };
constexpr uint32_t BINS = 2 * KINDS;

// Where the jobs of each bin begin.
struct Places {
    uint32_t first[BINS];
};

// What decides which workgroups there are: `Wanted` of src/cuda/hardware.rs.
struct Wanted {
    // A bit for each kind that the fill rule draws.
    uint32_t kinds;
    // Pixel in the viewport's middle, and half the viewport's side.
    int32_t middle[2];
    int32_t half_viewport;
};

static __device__ __forceinline__ float denominator(const View &view, const Patch &patch, const float4 &p) {
    return view.perspective != 0 ? p.z + patch.depth_origin * p.w : p.w;
}

static __device__ __forceinline__ float2 pixel_of(const View &view, const Patch &patch, const float4 &p) {
    const float by = denominator(view, patch, p);
    return make_float2(p.x / by, p.y / by);
}

static __device__ __forceinline__ float distance(float2 a, float2 b) {
    const float x = a.x - b.x, y = a.y - b.y;
    return sqrtf(x * x + y * y);
}

// A leaf's triangles are at least so large by ETER's bound on their edges, in pixels: its first-derivative rule (section 6.2,
// equation 2), on the projected net.
static __device__ __forceinline__ bool edges_reach(const View &view, const Patch &patch, Buffer<const Point> nets, float pixels) {
    const int m = patch.degree[0], n = patch.degree[1];
    const Buffer<const float4> net = as<const float4>(nets + patch.net);
    float radius = 0.0f, least = INFINITY;
    for (int k = 0; k < (m + 1) * (n + 1); k++) {
        radius = larger(distance(pixel_of(view, patch, net[k]), make_float2(0.0f, 0.0f)), radius);
        least = smaller(denominator(view, patch, net[k]), least);
    }
    if (pixels >= 2.0f * radius) {
        return false;
    }
    const float reach = larger(radius - pixels, 0.0f);
    const auto size = [&](const float4 &a, const float4 &b) {
        const float apart = distance(make_float2(a.x, a.y), make_float2(b.x, b.y));
        return apart + reach * fabsf(denominator(view, patch, a) - denominator(view, patch, b));
    };
    float along_u = 0.0f, along_v = 0.0f;
    for (int i = 0; i <= m; i++) {
        for (int j = 0; j <= n; j++) {
            const float4 here = net[i * (n + 1) + j];
            if (i < m) {
                along_u = larger(size(net[(i + 1) * (n + 1) + j], here), along_u);
            }
            if (j < n) {
                along_v = larger(size(net[i * (n + 1) + j + 1], here), along_v);
            }
        }
    }
    const float edges = along_u * float(m) / float(patch.quads[0]) + along_v * float(n) / float(patch.quads[1]);
    return edges / least >= pixels;
}

// How long a quad's sides may be, in pixels: by the projected net's first differences.
static __device__ __forceinline__ float quad_side(const View &view, const Patch &patch, Buffer<const Point> nets) {
    const int m = patch.degree[0], n = patch.degree[1];
    const Buffer<const float4> net = as<const float4>(nets + patch.net);
    float along_u = 0.0f, along_v = 0.0f;
    for (int i = 0; i <= m; i++) {
        for (int j = 0; j <= n; j++) {
            const float2 here = pixel_of(view, patch, net[i * (n + 1) + j]);
            if (i < m) {
                along_u = larger(distance(pixel_of(view, patch, net[(i + 1) * (n + 1) + j]), here), along_u);
            }
            if (j < n) {
                along_v = larger(distance(pixel_of(view, patch, net[i * (n + 1) + j + 1]), here), along_v);
            }
        }
    }
    return larger(along_u * float(m) / float(patch.quads[0]), along_v * float(n) / float(patch.quads[1]));
}

// Some vertex lies beyond the viewport: the same question as `is_far` of vk_shaders/geometry.glsl.
static __device__ __forceinline__ bool is_far(const Wanted &wanted, const Meshlet &m, Buffer<const Vertex> vertices) {
    const int count = (m.quads[0] + 1) * (m.quads[1] + 1), most = (wanted.half_viewport - 1) * SUBPIXELS;
    bool far = false;
    for (int k = 0; k < count && !far; k++) {
        const Vertex v = vertices[m.vertices + k];
        far = abs(v.x - wanted.middle[0] * SUBPIXELS) > most || abs(v.y - wanted.middle[1] * SUBPIXELS) > most;
    }
    return far;
}

// How many workgroups a meshlet's items of a kind take.
static __device__ __forceinline__ uint32_t groups(uint32_t kind, const Wanted &wanted, const Meshlet &m, const Patch &patch,
                                                  const Leaf &leaf, Buffer<const Vertex> vertices) {
    if ((wanted.kinds >> kind & 1) == 0) {
        return 0;
    }
    const uint32_t quads = uint32_t(m.quads[0]) * m.quads[1];
    const auto of = [](bool is_drawn, uint32_t items) { return is_drawn ? (items + ITEMS - 1) / ITEMS : 0; };
    switch (kind) {
    case FAR: return of(is_far(wanted, m, vertices), 2 * quads);
    case BORDERS: return of(m.outer != 0, 1);
    case FOLDS: return of(leaf.pen_fold > 0, 3 * quads);
    case TURNED_AWAY: return of(leaf.pen_fold > 0 && patch.hidden != 0, 2 * quads);
    case CONSERVATIVE: return of(true, 2 * quads);
    default: return 1;
    }
}

// Room for `count` more of a bin, by one atomic for all of a warp; all lanes together. The lane's own place.
static __device__ __forceinline__ uint64_t take(Buffer<uint64_t> counter, uint32_t count) {
    const int lane = threadIdx.x % 32;
    uint32_t before = count;
    for (int step = 1; step < 32; step *= 2) {
        const uint32_t other = __shfl_up_sync(~0u, before, step);
        before += lane >= step ? other : 0;
    }
    const uint32_t all = __shfl_sync(~0u, before, 31);
    unsigned long long first = 0;
    if (lane == 0 && all > 0) {
        first = atomicAdd(counts::word(counter[0]), (unsigned long long)all);
    }
    return __shfl_sync(~0u, first, 0) + before - count;
}

} // namespace hardware

// A thread a leaf: whether its quads are large enough, by their sides or by ETER's rule. 0: any quads are.
extern "C" __global__ void __launch_bounds__(THREADS)
    hardware_leaves(const __grid_constant__ View view, Count count, Buffer<const Patch> patches, Buffer<const Point> nets,
                    float large, uint32_t by_edges, Buffer<uint8_t> taken) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    if (k < count.get()) {
        taken[k] = large <= 0.0f
                   || (by_edges ? hardware::edges_reach(view, patches[k], nets, large)
                                : hardware::quad_side(view, patches[k], nets) >= large);
    }
}
KERNEL(hardware_leaves)

// A thread a meshlet: those of leaves that are taken are marked. `textured`: trims are textures, which software looks up.
// `counted`: how many meshlets, and their triangles.
extern "C" __global__ void __launch_bounds__(THREADS)
    hardware_marks(Count count, Buffer<const uint8_t> taken, uint32_t textured, Buffer<Meshlet> meshlets,
                   Buffer<uint64_t> counted) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    uint32_t triangles = 0;
    if (k < count.get()) {
        const Meshlet m = meshlets[k];
        if (taken[m.patch] && !(m.tested && textured)) {
            meshlets[k].tested = uint8_t(m.tested | MESHLET_ELSEWHERE);
            triangles = 2u * m.quads[0] * m.quads[1];
        }
    }
    hardware::take(counted, triangles > 0);
    hardware::take(counted + 1, triangles);
}
KERNEL(hardware_marks)

// A thread a meshlet: counts the workgroups of those that are marked, by bins; where `out` is not null, lists them there, in any
// order.
extern "C" __global__ void __launch_bounds__(THREADS)
    hardware_jobs(Count count, Buffer<const Patch> patches, Buffer<const Leaf> leaves, Buffer<const Meshlet> meshlets,
                  Buffer<const Vertex> vertices, const __grid_constant__ hardware::Wanted wanted, Buffer<uint64_t> counted,
                  const __grid_constant__ hardware::Places places, Buffer<uint32_t> out) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    const bool drawn = k < count.get() && (meshlets[k].tested & MESHLET_ELSEWHERE) != 0;
    const Meshlet m = drawn ? meshlets[k] : Meshlet{};
    for (uint32_t bin = 0; bin < hardware::BINS; bin++) {
        const bool own = drawn && (m.tested & MESHLET_TESTED) == bin % 2;
        const uint32_t groups =
            own ? hardware::groups(bin / 2, wanted, m, patches[m.patch], leaves[m.patch], vertices) : 0;
        const uint64_t place = hardware::take(counted + bin, groups);
        for (uint32_t part = 0; part < groups && out; part++) {
            out[places.first[bin] + place + part] = k | part << (32 - INDEX_BITS);
        }
    }
}
KERNEL(hardware_jobs)
