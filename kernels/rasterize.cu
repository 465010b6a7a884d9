// rasterize: triangles and strokes into the two 64-bit buffers (DESIGN section 4; the staged frame). Twin of
// src/stages/rasterize.rs.
//
// One warp a meshlet, a lane a triangle; triangles of many pixels are drawn by all lanes together.
#include "outlines.cuh"

namespace rasterize {

constexpr int WARPS = 4;

static __device__ __forceinline__ void triangles(const outlines::Drawn &d, Buffer<Word> near, int lane) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    outlines::for_all(
        topology::triangles(d.m), lane,
        [&](int k) {
            const Corners c = corners(k);
            return faces_away(c, d.patch.hidden) ? 0 : outlines::pixels_of(Coverage::box_of(d.view, c));
        },
        [&](int k, int first, int step) {
            const Corners c = corners(k);
            Coverage::of(c, Coverage::box_of(d.view, c)).each(d.id(k), first, step, [&](int x, int y, Word word) {
                keep_larger(near, uint32_t(y) * d.view.size[0] + x, word);
            });
        });
}

} // namespace rasterize

// The triangles of all meshlets but those that trim tests; a grid of ceil(count / 4) blocks, as below.
extern "C" __global__ void __launch_bounds__(rasterize::WARPS * 32)
    rasterize_triangles(const __grid_constant__ View view, GEOMETRY, uint32_t count, Buffer<Word> near) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * rasterize::WARPS + threadIdx.x / 32;
    if (number < count && !in.meshlets[number].tested) {
        const Meshlet m = in.meshlets[number];
        rasterize::triangles({view, in, m, in.patches[m.patch], in.leaves[m.patch], number}, near, threadIdx.x % 32);
    }
}
KERNEL(rasterize_triangles)

// Their strokes. Fill wants nothing that N hides, so that N is done first.
extern "C" __global__ void __launch_bounds__(rasterize::WARPS * 32)
    rasterize_strokes(const __grid_constant__ View view, GEOMETRY, uint32_t count, Buffer<const Word> near,
                      Buffer<Word> spare) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * rasterize::WARPS + threadIdx.x / 32;
    if (number >= count || in.meshlets[number].tested) {
        return;
    }
    const Meshlet m = in.meshlets[number];
    const outlines::Drawn d = {view, in, m, in.patches[m.patch], in.leaves[m.patch], number};
    outlines::draw(d, count, threadIdx.x % 32, [&](int x, int y, Word word) {
        const uint32_t pixel = uint32_t(y) * view.size[0] + x;
        if (topology::depth_of(word) > topology::depth_of(near[pixel])) {
            keep_larger(spare, pixel, word);
        }
    });
}
KERNEL(rasterize_strokes)
