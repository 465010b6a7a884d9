// trim: fragments of meshlets that a trim curve crosses are tested on the exact surface (DESIGN section 5). Twin of
// src/stages/trim.rs.
//
// A fragment's interpolated parameters may be half a pixel off. Where all parameters that near lie on one side, that decides,
// for a whole triangle or for a fragment. The others are listed, refined to the pixel's centre and tested there, so that both
// faces at an edge cut at the same place; a point outside but within the model's own gap of a curve counts as inside, so that
// the faces meet.
#include "bands.cuh"
#include "interpolate.cuh"
#include "shading.cuh"
#include "trim_cut.cuh"

namespace trim {

constexpr int WARPS = THREADS / 32;
// Blocks that a multiprocessor should hold at least: with more, registers are spilled.
constexpr int BLOCKS = 2;
using Warp = outlines::Group<32>;

// What trimming did: places in the list of counts.
constexpr int LISTED = 0, REJECTED = 1, PROPOSED = 2, COUNTS = 3;

// Fragments near a curve.
struct Queue {
    Buffer<Fragment> list;
    Buffer<uint64_t> counts;
    uint32_t room;

    __device__ __forceinline__ void push(uint32_t pixel, Word word) const {
        const uint64_t place = counts::next(counts[LISTED]);
        if (place < room) {
            Fragment fragment = {word, pixel, 0};
            list[place] = fragment;
        }
    }
};

static __device__ __forceinline__ double2 interpolated(const outlines::Drawn &d, uint32_t index, int x, int y) {
    const float2 s = interpolate::at(d.in, d.patch, d.m, index, x, y);
    return make_double2(s.x, s.y);
}

// Where a triangle lies, the errors of its fragments included.
static __device__ __forceinline__ uint32_t region(const outlines::Drawn &d, const trims::Trims &trims,
                                                  const topology::Primitive &p, const trims::Spread &spread) {
    double low[2], high[2];
#pragma unroll
    for (int k = 0; k < 2; k++) {
        const int a = k == 0 ? p.corner[0].i : p.corner[0].j, b = k == 0 ? p.corner[1].i : p.corner[1].j;
        const int c = k == 0 ? p.corner[2].i : p.corner[2].j, first = d.m.first[k];
        low[k] = double(first + min(min(a, b), c)) / double(d.patch.quads[k]) - spread.s[k];
        high[k] = double(first + max(max(a, b), c)) / double(d.patch.quads[k]) + spread.s[k];
    }
    return trims::classify(trims, d.leaf.tree, trims::plane_box(d.leaf, low, high));
}

// Draws the fragments of a triangle that no curve comes near to, and lists the others; those in a part of its box.
static __device__ __forceinline__ void triangle(const outlines::Drawn &d, const trims::Trims &trims, int index,
                                                const Corners &corners, const PixelBox &box, int first, int step,
                                                Buffer<Word> near, const Queue &queue) {
    const topology::Primitive p = topology::triangle(d.m, d.patch.diagonal, index);
    const trims::Spread spread = trims::spread(trims, d.patch, d.leaf, p, corners);
    const uint32_t whole = region(d, trims, p, spread);
    if (whole == REGION_OUTSIDE) {
        return;
    }
    const auto found = [&](int x, int y, Word word) {
        const uint32_t pixel = uint32_t(y) * d.view.size[0] + x;
        if (racy_load(&near[pixel]) >= word) {
            return;
        }
        uint32_t here = whole;
        if (here == REGION_BOUNDARY) {
            const double2 s = interpolated(d, index, x, y);
            here = trims::classify(trims, d.leaf, s.x, s.y, spread.s);
        }
        if (here == REGION_INSIDE) {
            keep_larger(near, pixel, word);
        } else if (here == REGION_BOUNDARY) {
            queue.push(pixel, word);
        }
    };
    coverage::each(box, corners, d.id(index), first, step, found);
}

// A fragment for the spare buffer. One that stays as it is shows its own parameters, so that these are tested; one that only
// proposes a pixel is refused where nothing of the face is near.
static __device__ __noinline__ bool keeps_stroke(const outlines::Drawn &d, const trims::Trims &trims, int x, int y,
                                                    Word word) {
    const uint32_t index = topology::index_of(word);
    // A fold has no parameters of its own.
    if (index == FOLD_INDEX) {
        return true;
    }
    const double2 s = interpolated(d, index, x, y);
    if (d.view.refine == 0 || d.view.fill != FILL_STROKE) {
        return trims::contains(trims, d.leaf, d.m.patch, s.x, s.y);
    }
    const topology::Primitive p = topology::primitive(d.m, d.patch.diagonal, index);
    // The pen's width, and as much again to what lies under the pixel's centre.
    trims::Spread spread = trims::spread(trims, d.patch, d.leaf, p, d.corners(p));
    spread.s[0] *= 2.0;
    spread.s[1] *= 2.0;
    // Edge-on there is no telling.
    return !spread.is_finite() || trims::classify(trims, d.leaf, s.x, s.y, spread.s) != REGION_OUTSIDE;
}

} // namespace trim

// The tested meshlets; a grid of ceil(count / 4) blocks. `counted`: trim::COUNTS of them.
extern "C" __global__ void __launch_bounds__(THREADS, trim::BLOCKS)
    trim_meshlets(GEOMETRY, Count count, const __grid_constant__ trims::Trims trims, Buffer<Word> near, uint32_t room,
                  Buffer<Fragment> queue, Buffer<uint64_t> counted, const __grid_constant__ bands::Bands bands) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * trim::WARPS + threadIdx.x / 32;
    if (number >= count.get() || in.meshlets[number].tested != MESHLET_TESTED) {
        return;
    }
    const Meshlet m = in.meshlets[number];
    const Patch &patch = in.patches[m.patch];
    SHARED(Vertex, tiles, [trim::WARPS][64]);
    const Span<Vertex> tile = tiles[threadIdx.x / 32];
    const trim::Warp warp = trim::Warp::here();
    outlines::load(warp, in, m, tile);
    const outlines::Drawn d = {view, in, m, patch, in.leaves[m.patch], number, tile};
    outlines::for_all(
        warp, topology::triangles(m),
        [&](int k) {
            const Corners c = d.corners(topology::triangle(m, patch.diagonal, k));
            return faces_away(c, patch.hidden) ? 0 : outlines::pixels_of(coverage::box_of(view, c));
        },
        [&](int k, int first, int step) {
            const Corners c = d.corners(topology::triangle(m, patch.diagonal, k));
            const PixelBox box = coverage::box_of(view, c);
            if (step == 1 || !bands.take(box) || !bands.hand_on(warp, number, k, box)) {
                trim::triangle(d, trims, k, c, box, first, step, near, {queue, counted, room});
            }
        });
}
KERNEL(trim_meshlets)

// What was handed on, a warp a band.
extern "C" __global__ void __launch_bounds__(THREADS, trim::BLOCKS)
    trim_bands(GEOMETRY, Count, const __grid_constant__ trims::Trims trims, Buffer<Word> near, uint32_t room,
               Buffer<Fragment> queue, Buffer<uint64_t> counted, const __grid_constant__ bands::Bands bands) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    bands::for_all(bands, [&](const Band &band) {
        const Meshlet m = in.meshlets[band.meshlet];
        const Patch &patch = in.patches[m.patch];
        // Nobody asks for the meshlet's other vertices.
        const outlines::Drawn d = {view, in, m, patch, in.leaves[m.patch], band.meshlet, {}};
        const Corners c = topology::corners(in, m, topology::triangle(m, patch.diagonal, band.triangle));
        const PixelBox box = bands::box_in(coverage::box_of(view, c), band);
        trim::triangle(d, trims, int(band.triangle), c, box, threadIdx.x % 32, 32, near, {queue, counted, room});
    });
}
KERNEL(trim_bands)

// The listed fragments, on the exact surface.
extern "C" __global__ void __launch_bounds__(THREADS)
    trim_fragments(GEOMETRY, const __grid_constant__ trims::Trims trims, Buffer<Word> near, Buffer<Word> spare,
                   Buffer<const Fragment> queue, Count count, Buffer<uint64_t> counted) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Word word = queue[k].word;
    const uint32_t pixel = queue[k].pixel;
    const int x = pixel % view.size[0], y = pixel / view.size[0];
    const Meshlet m = in.meshlets[topology::meshlet_of(word)];
    const Leaf &leaf = in.leaves[m.patch];
    const float2 start = interpolate::at(in, in.patches[m.patch], m, topology::index_of(word), x, y);
    const float2 target = refinement::target(view, leaf, x, y);
    const refinement::Refined r =
        refinement::refine(Surface::of(view, in, m.patch, false), view.refine, start.x, start.y, target.x, target.y);
    if (trims::keeps(trims, view, leaf, m.patch, r)) {
        keep_larger(near, pixel, word);
        return;
    }
    counts::next(counted[trim::REJECTED]);
    // It was not tested under the pixel's centre: whatever surface lies there is searched for.
    if (r.residual > shading::EXACT && view.refine > 0 && view.fill == FILL_STROKE) {
        counts::next(counted[trim::PROPOSED]);
        keep_larger(spare, pixel, topology::word(topology::depth_of(word), topology::meshlet_of(word), FOLD_INDEX));
    }
}
KERNEL(trim_fragments)

// Strokes of the tested meshlets, once the near buffer is done.
extern "C" __global__ void __launch_bounds__(THREADS, trim::BLOCKS)
    trim_strokes(GEOMETRY, Count count, const __grid_constant__ trims::Trims trims, Buffer<const Word> near,
                 Buffer<Word> spare) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * trim::WARPS + threadIdx.x / 32;
    if (number >= count.get() || in.meshlets[number].tested != MESHLET_TESTED) {
        return;
    }
    // Not a copy, which would take registers.
    const Meshlet &m = in.meshlets[number];
    SHARED(Vertex, tiles, [trim::WARPS][64]);
    const Span<Vertex> tile = tiles[threadIdx.x / 32];
    const trim::Warp warp = trim::Warp::here();
    outlines::load(warp, in, m, tile);
    const outlines::Drawn d = {view, in, m, in.patches[m.patch], in.leaves[m.patch], number, tile};
    outlines::draw(warp, d, count.get(), [&](int x, int y, Word word) {
        const uint32_t pixel = uint32_t(y) * view.size[0] + x;
        // Fill wants nothing that N hides.
        const bool nearer = topology::depth_of(word) > topology::depth_of(near[pixel]);
        if (nearer && racy_load(&spare[pixel]) < word && trim::keeps_stroke(d, trims, x, y, word)) {
            keep_larger(spare, pixel, word);
        }
    });
}
KERNEL(trim_strokes)
