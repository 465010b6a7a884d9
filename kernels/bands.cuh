// Triangles of many pixels, handed on to many warps: bands of rows, a warp each. A warp that drew a face across the whole screen
// by itself would be waited for by all others.
#pragma once
#include "outlines.cuh"

namespace bands {

// Pixels of a box that one warp draws by itself: a few hundred rounds.
constexpr i64 MOST_PIXELS = 1 << 14;
// Rows of a band.
constexpr i64 ROWS = 8;
// `Band::triangle` of a place that holds none.
constexpr uint32_t NONE = 0xffffffffu;

// Where they are handed on; `list` is null where nobody takes them.
struct Bands {
    Buffer<Band> list;
    Buffer<uint64_t> counted;
    uint32_t room;

    __device__ __forceinline__ bool take(const PixelBox &box) const { return list && outlines::pixels_of(box) > MOST_PIXELS; }

    // A warp together: false where there is no room, and the warp draws it after all.
    __device__ bool hand_on(const outlines::Group<32> &warp, uint32_t meshlet, uint32_t triangle, const PixelBox &box) const {
        const uint32_t count = uint32_t((box.y.high - box.y.low) / ROWS + 1);
        unsigned long long first = 0;
        if (warp.lane == 0) {
            first = atomicAdd(counts::word(counted[0]), (unsigned long long)count);
        }
        first = __shfl_sync(~0u, first, 0);
        const bool fits = first + count <= room;
        for (uint32_t k = warp.lane; k < count && first + k < room; k += 32) {
            list[first + k] = {meshlet, fits ? triangle : NONE, uint32_t(box.y.low + k * ROWS), 0};
        }
        return fits;
    }
};

// Calls draw(band) for all of them, a warp a band.
template <class Draw> static __device__ __forceinline__ void for_all(const Bands &bands, Draw draw) {
    constexpr uint32_t WARPS = THREADS / 32;
    const uint64_t all = bands.counted[0];
    const uint32_t count = all < bands.room ? uint32_t(all) : bands.room;
    for (uint32_t k = blockIdx.x * WARPS + threadIdx.x / 32; k < count; k += gridDim.x * WARPS) {
        const Band band = bands.list[k];
        if (band.triangle != NONE) {
            draw(band);
        }
    }
}

// The part of a triangle's box that lies in a band.
static __device__ __forceinline__ PixelBox box_in(const PixelBox &box, const Band &band) {
    return {box.x, {i64(band.row), min(box.y.high, i64(band.row) + ROWS - 1)}};
}

} // namespace bands
