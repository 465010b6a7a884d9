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

// All meshlets but those that trim tests; a grid of ceil(count / 4) blocks.
extern "C" __global__ void __launch_bounds__(rasterize::WARPS * 32)
    rasterize_meshlets(const __grid_constant__ View view, GEOMETRY, uint32_t count, Buffer<Word> near, Buffer<Word> spare) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * rasterize::WARPS + threadIdx.x / 32;
    const int lane = threadIdx.x % 32;
    if (number >= count) {
        return;
    }
    const Meshlet m = in.meshlets[number];
    if (m.tested) {
        return;
    }
    const Patch patch = in.patches[m.patch];
    const Leaf leaf = in.leaves[m.patch];
    const outlines::Drawn drawn = {view, in, m, patch, leaf, number};
    rasterize::triangles(drawn, near, lane);
    outlines::draw(drawn, count, lane, [&](int x, int y, Word word) {
        keep_larger(spare, uint32_t(y) * view.size[0] + x, word);
    });
}
KERNEL(rasterize_meshlets)
