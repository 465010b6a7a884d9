// rasterize: triangles and strokes into the two 64-bit buffers (DESIGN section 4). Twin of src/stages/rasterize.rs.
//
// A group of lanes a meshlet, a lane a triangle or an edge; what has many pixels is drawn by all of them together. The staged
// frame draws all meshlets by warps, from vertices in memory. The fused frame sorts them into classes first, so that small
// grids leave no lane idle (research "kernel-study", question 3), and evaluates the vertices here: only shared memory sees
// them. Small grids that are large on the screen go to the class of large ones.
#include "outlines.cuh"

namespace rasterize {

// Blocks that a multiprocessor should hold at least: without it, registers are spilled to hold more.
constexpr int BLOCKS = 4;

// Meshlets of one class.
struct List {
    // Their numbers; null: all meshlets.
    Buffer<const uint32_t> numbers;
    uint32_t length;
};

// Places in the list of counts: meshlets of each class.
constexpr int CORNERS = 0, NARROW = 1, WIDE = 2;
// Pixels of a meshlet's box that few lanes are enough for.
constexpr i64 MOST_PIXELS = 4096;

template <int LANES>
static __device__ __forceinline__ void triangles(const outlines::Group<LANES> &group, const outlines::Drawn &d,
                                                 Buffer<Word> near) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    outlines::for_all(
        group, topology::triangles(d.m),
        [&](int k) {
            const Corners c = corners(k);
            return faces_away(c, d.patch.hidden) ? 0 : outlines::pixels_of(coverage::box_of(d.view, c));
        },
        [&](int k, int first, int step) {
            coverage::each(d.view, corners(k), d.id(k), first, step, [&](int x, int y, Word word) {
                keep_larger(near, uint32_t(y) * d.view.size[0] + x, word);
            });
        });
}

// The meshlet's vertices span more pixels than few lanes should draw.
static __device__ __forceinline__ bool is_large(const View &view, const Meshlet &m, Span<const Vertex> tile) {
    int low_x = tile[0].x, high_x = low_x, low_y = tile[0].y, high_y = low_y;
    for (int k = 1; k < (m.quads[0] + 1) * (m.quads[1] + 1); k++) {
        low_x = min(low_x, tile[k].x);
        high_x = max(high_x, tile[k].x);
        low_y = min(low_y, tile[k].y);
        high_y = max(high_y, tile[k].y);
    }
    return outlines::pixels_of(pixels_in(view, {low_x, high_x}, {low_y, high_y})) > MOST_PIXELS;
}

// What is drawn: triangles into the near buffer, or, once that is done, strokes into the spare one. Apart, they take half the
// registers.
enum Part { TRIANGLES, STROKES };

struct Targets {
    Buffer<Word> near;
    Buffer<Word> spare;
};

template <int LANES>
static __device__ __forceinline__ void strokes(const outlines::Group<LANES> &group, const outlines::Drawn &d, uint32_t count,
                                               const Targets &targets) {
    outlines::draw(group, d, count, [&](int x, int y, Word word) {
        const uint32_t pixel = uint32_t(y) * d.view.size[0] + x;
        // Fill wants nothing that N hides.
        if (topology::depth_of(word) > topology::depth_of(targets.near[pixel])) {
            keep_larger(targets.spare, pixel, word);
        }
    });
}

// One class of meshlets. `wide`, where it is not null, takes those that are too large for it.
template <Part PART, int LANES, int VERTICES>
static __device__ __forceinline__ void meshlets(const Geometry &in, uint32_t count, const List &list, Buffer<uint32_t> wide,
                                                Buffer<uint32_t> counts, const Targets &targets) {
    constexpr int GROUPS = THREADS / LANES;
    SHARED(Vertex, tiles, [GROUPS][VERTICES]);
    const outlines::Group<LANES> group = outlines::Group<LANES>::here();
    const int own = threadIdx.x / LANES;
    for (uint32_t k = blockIdx.x * GROUPS + own; k < list.length; k += gridDim.x * GROUPS) {
        const uint32_t number = list.numbers ? list.numbers[k] : k;
        const Meshlet m = in.meshlets[number];
        if (m.tested) {
            continue;
        }
        const Span<Vertex> tile = tiles[own];
        outlines::load(group, in, m, tile);
        const outlines::Drawn d = {in.view, in, m, in.patches[m.patch], in.leaves[m.patch], number, tile};
        if (LANES < 32 && is_large(in.view, m, tile)) {
            if (PART == TRIANGLES && group.lane == 0) {
                wide[atomicAdd(&counts[WIDE], 1u)] = number;
            }
        } else if (PART == TRIANGLES) {
            triangles(group, d, targets.near);
        } else {
            strokes(group, d, count, targets);
        }
        // The next meshlet overwrites the tile.
        group.sync();
    }
}

} // namespace rasterize

// All meshlets but those that trim tests, by warps.
extern "C" __global__ void __launch_bounds__(THREADS, rasterize::BLOCKS)
    rasterize_triangles(GEOMETRY, Count all, Buffer<Word> near) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t count = all.get();
    rasterize::meshlets<rasterize::TRIANGLES, 32, 64>(in, count, {{}, count}, {}, {}, {near, {}});
}
KERNEL(rasterize_triangles)

extern "C" __global__ void __launch_bounds__(THREADS, rasterize::BLOCKS)
    rasterize_strokes(GEOMETRY, Count all, Buffer<Word> near, Buffer<Word> spare) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t count = all.get();
    rasterize::meshlets<rasterize::STROKES, 32, 64>(in, count, {{}, count}, {}, {}, {near, spare});
}
KERNEL(rasterize_strokes)

// Sorts them into classes: three lists with room for all, and `counts` how many each has.
extern "C" __global__ void __launch_bounds__(THREADS)
    rasterize_classes(Buffer<const Meshlet> meshlets, Count count, Buffer<uint32_t> corners, Buffer<uint32_t> narrow,
                      Buffer<uint32_t> wide, Buffer<uint32_t> counts) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    int which = -1;
    if (k < count.get() && !meshlets[k].tested) {
        const Meshlet m = meshlets[k];
        const int points = (m.quads[0] + 1) * (m.quads[1] + 1);
        which = points == 4 ? rasterize::CORNERS : points <= 16 ? rasterize::NARROW : rasterize::WIDE;
    }
    // One atomic for all of a warp's in one class.
    const unsigned peers = __match_any_sync(~0u, which);
    const int leader = __ffs(peers) - 1, lane = threadIdx.x % 32;
    uint32_t first = 0;
    if (lane == leader && which >= 0) {
        first = atomicAdd(&counts[which], uint32_t(__popc(peers)));
    }
    first = __shfl_sync(~0u, first, leader) + __popc(peers & ((1u << lane) - 1));
    if (which >= 0) {
        const Buffer<uint32_t> list = which == rasterize::CORNERS ? corners : which == rasterize::NARROW ? narrow : wide;
        list[first] = k;
    }
}
KERNEL(rasterize_classes)

#define RASTERIZE(name, PART, LANES, VERTICES, CLASS)                                                                  \
    extern "C" __global__ void __launch_bounds__(THREADS, rasterize::BLOCKS)                                           \
        name(GEOMETRY, Count all, Buffer<const uint32_t> numbers, Buffer<uint32_t> wide, Buffer<uint32_t> counts,      \
             Buffer<Word> near, Buffer<Word> spare) {                                                                  \
        const Geometry in = GEOMETRY_ARGUMENTS;                                                                        \
        const rasterize::List list = {numbers, counts[rasterize::CLASS]};                                              \
        rasterize::meshlets<rasterize::PART, LANES, VERTICES>(in, all.get(), list, wide, counts, {near, spare});       \
    }                                                                                                                  \
    KERNEL(name)

// A thread a meshlet of one quad.
RASTERIZE(rasterize_corners, TRIANGLES, 1, 4, CORNERS)
RASTERIZE(stroke_corners, STROKES, 1, 4, CORNERS)
// Eight lanes a meshlet of up to 16 vertices.
RASTERIZE(rasterize_narrow, TRIANGLES, 8, 16, NARROW)
RASTERIZE(stroke_narrow, STROKES, 8, 16, NARROW)
// A warp a meshlet.
RASTERIZE(rasterize_wide, TRIANGLES, 32, 64, WIDE)
RASTERIZE(stroke_wide, STROKES, 32, 64, WIDE)
