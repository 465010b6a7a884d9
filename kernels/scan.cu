// Exclusive prefix sums of 32-bit numbers, with a 64-bit total: in tiles, over the tiles' sums, and added together. No block
// waits for another one.
#include "count.cuh"

namespace scan {

constexpr uint32_t THREADS = 256;
constexpr uint32_t EACH = 8;
constexpr uint32_t TILE = THREADS * EACH;

// The exclusive sum over the block's threads; `total` is that of all.
static __device__ __forceinline__ uint64_t over_block(uint64_t value, uint64_t &total) {
    SHARED(uint64_t, warps, [THREADS / 32]);
    const uint32_t lane = threadIdx.x % 32, warp = threadIdx.x / 32;
    uint64_t sum = value;
    for (uint32_t step = 1; step < 32; step *= 2) {
        const unsigned long long below = __shfl_up_sync(~0u, (unsigned long long)sum, step);
        sum += lane >= step ? below : 0;
    }
    if (lane == 31) {
        warps[warp] = sum;
    }
    __syncthreads();
    uint64_t before = 0;
    total = 0;
    for (uint32_t k = 0; k < THREADS / 32; k++) {
        before += k < warp ? warps[k] : 0;
        total += warps[k];
    }
    // The next sum overwrites these.
    __syncthreads();
    return before + sum - value;
}

} // namespace scan

// A block a tile of 2048 numbers: sums within it, and its own.
extern "C" __global__ void __launch_bounds__(scan::THREADS)
    scan_tiles(Buffer<const uint32_t> in, Buffer<uint32_t> out, Buffer<uint64_t> sums, Count list) {
    const uint32_t count = list.get();
    SHARED(uint32_t, tile, [scan::TILE]);
    const uint32_t first = blockIdx.x * scan::TILE;
    // Loads and stores are coalesced, sums run along eight neighbours.
    for (uint32_t k = threadIdx.x; k < scan::TILE; k += scan::THREADS) {
        tile[k] = first + k < count ? in[first + k] : 0;
    }
    __syncthreads();
    const uint32_t own = threadIdx.x * scan::EACH;
    uint64_t sum = 0, total;
    for (uint32_t k = 0; k < scan::EACH; k++) {
        sum += tile[own + k];
    }
    uint64_t before = scan::over_block(sum, total);
    for (uint32_t k = 0; k < scan::EACH; k++) {
        const uint32_t value = tile[own + k];
        tile[own + k] = uint32_t(before);
        before += value;
    }
    __syncthreads();
    for (uint32_t k = threadIdx.x; k < scan::TILE; k += scan::THREADS) {
        if (first + k < count) {
            out[first + k] = tile[k];
        }
    }
    if (threadIdx.x == 0) {
        sums[blockIdx.x] = total;
    }
}
KERNEL(scan_tiles)

// One block: the tiles' sums become what comes before each; `total[0]` is that of all.
extern "C" __global__ void __launch_bounds__(scan::THREADS)
    scan_sums(Buffer<uint64_t> sums, uint32_t tiles, Buffer<uint64_t> total) {
    uint64_t before = 0;
    for (uint32_t first = 0; first < tiles; first += scan::THREADS) {
        const uint32_t k = first + threadIdx.x;
        uint64_t all;
        const uint64_t sum = scan::over_block(k < tiles ? sums[k] : 0, all);
        if (k < tiles) {
            sums[k] = before + sum;
        }
        before += all;
    }
    if (threadIdx.x == 0) {
        total[0] = before;
    }
}
KERNEL(scan_sums)

// A thread a number.
extern "C" __global__ void __launch_bounds__(scan::THREADS)
    scan_add(Buffer<uint32_t> out, Buffer<const uint64_t> sums, Count list) {
    const uint32_t k = blockIdx.x * scan::THREADS + threadIdx.x;
    if (k < list.get()) {
        out[k] += uint32_t(sums[k / scan::TILE]);
    }
}
KERNEL(scan_add)

// As many as a list has, where all of another one fits too; else more than anybody has room for.
extern "C" __global__ void __launch_bounds__(1) count_both(Count list, Count other, Buffer<uint64_t> out) {
    out[0] = list.fits() && other.fits() ? list.all() : counts::TOO_MANY;
}
KERNEL(count_both)
