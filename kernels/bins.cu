// evaluate, which kernel for which meshlet: sorts a frame's meshlets into the bins that `Arithmetic::bin` of
// src/cuda/precision.rs numbers.
#include "count.cuh"
#include "topology.cuh"

namespace bins {

constexpr uint32_t NONE = 0xffffffffu;
// Degrees 1 to 7 that are the same in u and v have their own kernel in f32; 0 is for any.
constexpr uint32_t LARGEST_DEGREE = 7;
constexpr uint32_t F32_BINS = LARGEST_DEGREE + 1;

constexpr uint32_t BINS = F32_BINS + ARITHMETICS - 1;

// Where each bin begins, and how many meshlets it has room for.
struct Places {
    uint32_t first[BINS], room[BINS];
};

// Of a meshlet whose vertices are kept.
static __device__ __forceinline__ uint32_t bin_of(const Patch &patch, uint32_t arithmetic) {
    const bool same = patch.degree[0] == patch.degree[1] && patch.degree[0] <= LARGEST_DEGREE;
    return arithmetic > 0 ? F32_BINS + arithmetic - 1 : same ? patch.degree[0] : 0;
}

} // namespace bins

// Counts the meshlets of each bin; where `out` is not null, puts those there that the bin has room for, in any order. Those
// without vertices are in none.
extern "C" __global__ void __launch_bounds__(THREADS)
    evaluate_bins(Buffer<const Patch> patches, Buffer<const Leaf> leaves, Buffer<const Meshlet> meshlets, Count count,
                  Buffer<uint64_t> counted, const __grid_constant__ bins::Places places, Buffer<Meshlet> out) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    uint32_t bin = bins::NONE;
    if (k < count.get() && meshlets[k].vertices != NO_VERTICES) {
        const uint32_t patch = meshlets[k].patch;
        bin = bins::bin_of(patches[patch], leaves[patch].arithmetic);
    }
    // One atomic for all of a warp's in one bin.
    const unsigned peers = __match_any_sync(0xffffffffu, bin);
    const int leader = __ffs(peers) - 1, lane = threadIdx.x % 32;
    unsigned long long first = 0;
    if (lane == leader && bin != bins::NONE) {
        first = atomicAdd(counts::word(counted[bin]), (unsigned long long)__popc(peers));
    }
    first = __shfl_sync(0xffffffffu, first, leader) + __popc(peers & ((1u << lane) - 1));
    if (out && bin != bins::NONE && first < places.room[bin]) {
        out[places.first[bin] + uint32_t(first)] = meshlets[k];
    }
}
KERNEL(evaluate_bins)

// A thread a meshlet: its vertices, where they are kept in the fused frame, made by tensor cores. Whole patches are, or are not:
// blocks of one patch have the same vertices where they meet.
extern "C" __global__ void __launch_bounds__(THREADS)
    evaluate_kept(Count count, Buffer<const Leaf> leaves, Buffer<const Meshlet> meshlets, Buffer<uint32_t> vertices) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    if (k < count.get()) {
        const Meshlet m = meshlets[k];
        vertices[k] = leaves[m.patch].arithmetic == ARITHMETIC_F32 ? 0 : (m.quads[0] + 1u) * (m.quads[1] + 1u);
    }
}
KERNEL(evaluate_kept)

// A thread a meshlet: where its vertices begin, or that there are none.
extern "C" __global__ void __launch_bounds__(THREADS)
    evaluate_places(Count count, Buffer<const uint32_t> vertices, Buffer<const uint32_t> firsts, Buffer<Meshlet> meshlets) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    if (k < count.get()) {
        meshlets[k].vertices = vertices[k] == 0 ? NO_VERTICES : firsts[k];
    }
}
KERNEL(evaluate_places)
