// rasterize: triangles and strokes into the two 64-bit buffers (DESIGN section 4). Twin of src/stages/rasterize.rs.
//
// A group of lanes a meshlet, a lane a triangle or an edge; what has many pixels is drawn by all of them together. The staged
// frame draws all meshlets by warps, from vertices in memory. The fused frame sorts them into classes first, so that small
// grids leave no lane idle (research "kernel-study", question 3), and in each class by degree and by how large quads are. It
// evaluates the vertices here: those of single quads and of rows of them in registers, others in shared memory. Small grids
// that are large on the screen go to the class of large ones.
#include "bands.cuh"

namespace rasterize {

// Meshlets of one class.
struct List {
    // Their numbers; null: all meshlets.
    Buffer<const uint32_t> numbers;
    uint32_t length;
};

// Classes of meshlets, each by degrees (1, 2, 3, and all others) and, within these, by boxes of quads (up to 4 pixels a side,
// up to 16, larger ones). A warp whose meshlets are alike does as one; it waits for its largest box.
constexpr int CORNERS = 0, STRIPS = 1, NARROW = 2, WIDE = 3, CLASSES = 4, DEGREES = 4, BOXES = 3, BINS = DEGREES * BOXES;
// Places in the list of counts: meshlets by class and bin, how many of them have been listed, and what few lanes handed on to
// the wide ones.
constexpr int CURSORS = CLASSES * BINS, HANDED_ON = 2 * CLASSES * BINS;
// Pixels of a triangle's box that few lanes are enough for.
constexpr i64 MOST_PIXELS = 1024;

// Triangles that are too many pixels for a warp are handed on.
template <int LANES>
static __device__ __forceinline__ void triangles(const outlines::Group<LANES> &group, const outlines::Drawn &d,
                                                 Buffer<Word> near, const bands::Bands &bands) {
    const auto corners = [&](int k) { return d.corners(topology::triangle(d.m, d.patch.diagonal, k)); };
    outlines::for_all(
        group, topology::triangles(d.m),
        [&](int k) {
            const Corners c = corners(k);
            return faces_away(c, d.patch.hidden) ? 0 : outlines::pixels_of(coverage::box_of(d.view, c));
        },
        [&](int k, int first, int step) {
            const Corners c = corners(k);
            const PixelBox box = coverage::box_of(d.view, c);
            if constexpr (LANES == 32) {
                if (step > 1 && bands.take(box) && bands.hand_on(group, d.number, k, box)) {
                    return;
                }
            }
            coverage::each(box, c, d.id(k), first, step, [&](int x, int y, Word word) {
                keep_larger(near, uint32_t(y) * d.view.size[0] + x, word);
            });
        });
}

// Few lanes should not draw it. Whoever asks of a meshlet's triangles gets the same answer, so that its strokes are drawn too.
static __device__ __forceinline__ bool is_large(const PixelBox &box) { return outlines::pixels_of(box) > MOST_PIXELS; }

template <int LANES>
static __device__ __forceinline__ bool is_large(const outlines::Group<LANES> &group, const outlines::Drawn &d) {
    bool large = false;
    for (int k = group.lane; k < topology::triangles(d.m); k += LANES) {
        large = large || is_large(coverage::box_of(d.view, d.corners(topology::triangle(d.m, d.patch.diagonal, k))));
    }
    return group.ballot(large) != 0;
}

// Meshlets of a class in bins before one.
static __device__ __forceinline__ uint32_t before(Buffer<const uint32_t> counts, int which, int bin) {
    uint32_t sum = 0;
    for (int k = 0; k < bin; k++) {
        sum += counts[which * BINS + k];
    }
    return sum;
}

static __device__ __forceinline__ void hand_on(Buffer<uint32_t> wide, Buffer<uint32_t> counts, uint32_t number) {
    wide[before(counts, WIDE, BINS) + atomicAdd(&counts[HANDED_ON], 1u)] = number;
}

// What is drawn: triangles into the near buffer, or, once that is done, strokes into the spare one. Apart, they take half the
// registers.
enum Part { TRIANGLES, STROKES };

struct Targets {
    Buffer<Word> near;
    Buffer<Word> spare;
    bands::Bands bands;
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

// A thread's meshlet: one quad, or a row of them along either side. Two vertices at a time, which no memory sees; false where a
// triangle is too large for a thread.
static __device__ __forceinline__ bool strip(const Geometry &in, uint32_t number, const Meshlet &m, const Patch &patch,
                                             Buffer<Word> near) {
    const bool along_v = m.quads[0] == 1;
    const int length = along_v ? m.quads[1] : m.quads[0];
    const auto at = [&](int side, int step) {
        return topology::load(in, m, along_v ? topology::Corner{side, step} : topology::Corner{step, side});
    };
    Vertex last[2] = {};
#pragma unroll 1
    for (int step = 0; step <= length; step++) {
        const Vertex low = at(0, step), high = at(1, step);
        // The quad's corners (0, 0), (1, 0), (1, 1) and (0, 1).
        const Vertex p = last[0], q = along_v ? last[1] : low, r = high, s = along_v ? low : last[1];
        last[0] = low, last[1] = high;
#pragma unroll 1
        for (int second = 0; second < 2 && step > 0; second++) {
            const bool main = patch.diagonal == 0;
            const Corners c = second ? Corners{{main ? p : q, r, s}} : Corners{{p, q, main ? r : s}};
            const PixelBox box = coverage::box_of(in.view, c);
            if (is_large(box)) {
                return false;
            }
            if (faces_away(c, patch.hidden) || box.empty()) {
                continue;
            }
            const Word id = topology::word(0.0f, number, uint32_t(2 * (step - 1) + second));
            coverage::each(box, c, id, 0, 1, [&](int x, int y, Word word) {
                keep_larger(near, uint32_t(y) * in.view.size[0] + x, word);
            });
        }
    }
    return true;
}

// One class of meshlets. `wide`, where it is not null, takes those that are too large for it.
template <Part PART, int LANES, int VERTICES>
static __device__ __forceinline__ void meshlets(const Geometry &in, uint32_t count, const List &list, Buffer<uint32_t> wide,
                                                Buffer<uint32_t> counts, const Targets &targets) {
    constexpr int GROUPS = THREADS / LANES;
    SHARED(Vertex, tiles, [GROUPS][VERTICES]);
    const outlines::Group<LANES> group = outlines::Group<LANES>::here();
    const int own = threadIdx.x / LANES;
    // Where there are fewer than warps, each block has one before any has two.
    const bool few = LANES == 32 && list.length < gridDim.x * GROUPS;
    for (uint32_t k = few ? own * gridDim.x + blockIdx.x : blockIdx.x * GROUPS + own; k < list.length;
         k += gridDim.x * GROUPS) {
        const uint32_t number = list.numbers ? list.numbers[k] : k;
        // Not a copy, which would take registers.
        const Meshlet &m = in.meshlets[number];
        if (m.tested) {
            continue;
        }
        const Span<Vertex> tile = tiles[own];
        outlines::load(group, in, m, tile);
        const outlines::Drawn d = {in.view, in, m, in.patches[m.patch], in.leaves[m.patch], number, tile};
        if (LANES < 32 && is_large(group, d)) {
            if (PART == TRIANGLES && group.lane == 0) {
                hand_on(wide, counts, number);
            }
        } else if (PART == TRIANGLES) {
            triangles(group, d, targets.near, targets.bands);
        } else {
            strokes(group, d, count, targets);
        }
        // The next meshlet overwrites the tile.
        group.sync();
    }
}

} // namespace rasterize

// All meshlets but those that trim tests, by warps.
extern "C" __global__ void __launch_bounds__(THREADS, BLOCKS)
    rasterize_triangles(GEOMETRY, Count all, Buffer<Word> near, const __grid_constant__ bands::Bands bands) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t count = all.get();
    rasterize::meshlets<rasterize::TRIANGLES, 32, 64>(in, count, {{}, count}, {}, {}, {near, {}, bands});
}
KERNEL(rasterize_triangles)

extern "C" __global__ void __launch_bounds__(THREADS, BLOCKS)
    rasterize_strokes(GEOMETRY, Count all, Buffer<Word> near, Buffer<Word> spare) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t count = all.get();
    rasterize::meshlets<rasterize::STROKES, 32, 64>(in, count, {{}, count}, {}, {}, {near, spare, {}});
}
KERNEL(rasterize_strokes)

namespace rasterize {

// How large a patch's quads are, as a place among `BOXES`: from its reach in pixels, as its rounding bound has it
// (`cull::rounding_bound`).
static __device__ __forceinline__ int box_bin(const Patch &patch) {
    const float gamma = float(patch.degree[0] + patch.degree[1] + 8);
    const float reach = patch.rounding * 16777216.0f / (2.0f * gamma + 2.0f);
    const float side = 2.0f * reach / float(max(max(int(patch.quads[0]), int(patch.quads[1])), 1));
    return side <= 4.0f ? 0 : side <= 16.0f ? 1 : 2;
}

// Where a meshlet belongs: class, degree and box; -1: trim draws it.
static __device__ __forceinline__ int bin_of(const Meshlet &m, const Patch &patch) {
    if (m.tested) {
        return -1;
    }
    const int points = (m.quads[0] + 1) * (m.quads[1] + 1);
    const bool row = m.quads[0] == 1 || m.quads[1] == 1;
    const int which = points == 4 ? CORNERS : row ? STRIPS : points <= 16 ? NARROW : WIDE;
    const int degree = min(max(max(int(patch.degree[0]), int(patch.degree[1])), 1), DEGREES) - 1;
    return (which * DEGREES + degree) * BOXES + box_bin(patch);
}

// One more of a bin, with one atomic for all of a warp's; all lanes together. Its place among those of the bin.
static __device__ __forceinline__ uint32_t next(Buffer<uint32_t> counters, int bin) {
    const unsigned peers = __match_any_sync(~0u, bin);
    const int leader = __ffs(peers) - 1, lane = threadIdx.x % 32;
    uint32_t first = 0;
    if (lane == leader && bin >= 0) {
        first = atomicAdd(&counters[bin], uint32_t(__popc(peers)));
    }
    return __shfl_sync(~0u, first, leader) + __popc(peers & ((1u << lane) - 1));
}

} // namespace rasterize

// Counts them by class and bin.
extern "C" __global__ void __launch_bounds__(THREADS)
    rasterize_classes(Buffer<const Patch> patches, Buffer<const Meshlet> meshlets, Count count, Buffer<uint32_t> counts) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    rasterize::next(counts, k < count.get() ? rasterize::bin_of(meshlets[k], patches[meshlets[k].patch]) : -1);
}
KERNEL(rasterize_classes)

// Sorts them: a list with room for all for each class, in order of bins.
extern "C" __global__ void __launch_bounds__(THREADS)
    rasterize_sort(Buffer<const Patch> patches, Buffer<const Meshlet> meshlets, Count count, Buffer<uint32_t> counts,
                   Buffer<uint32_t> corners, Buffer<uint32_t> strips, Buffer<uint32_t> narrow, Buffer<uint32_t> wide) {
    const uint32_t k = blockIdx.x * THREADS + threadIdx.x;
    const int bin = k < count.get() ? rasterize::bin_of(meshlets[k], patches[meshlets[k].patch]) : -1;
    const uint32_t place = rasterize::next(counts + rasterize::CURSORS, bin);
    if (bin >= 0) {
        const int which = bin / rasterize::BINS;
        const Buffer<uint32_t> list = which == rasterize::CORNERS  ? corners
                                      : which == rasterize::STRIPS ? strips
                                      : which == rasterize::NARROW ? narrow
                                                                   : wide;
        list[rasterize::before(counts, which, bin % rasterize::BINS) + place] = k;
    }
}
KERNEL(rasterize_sort)

#define RASTERIZE(name, PART, LANES, VERTICES, CLASS)                                                                  \
    extern "C" __global__ void __launch_bounds__(THREADS, BLOCKS)                                                      \
        name(GEOMETRY, Count all, Buffer<const uint32_t> numbers, Buffer<uint32_t> wide, Buffer<uint32_t> counts,      \
             Buffer<Word> near, Buffer<Word> spare, const __grid_constant__ bands::Bands bands) {                      \
        const Geometry in = GEOMETRY_ARGUMENTS;                                                                        \
        const bool all_wide = rasterize::CLASS == rasterize::WIDE;                                                     \
        const uint32_t length = rasterize::before(counts, rasterize::CLASS, rasterize::BINS)                        \
                                + (all_wide ? counts[rasterize::HANDED_ON] : 0);                                       \
        const rasterize::List list = {numbers, length};                                                                \
        rasterize::meshlets<rasterize::PART, LANES, VERTICES>(in, all.get(), list, wide, counts, {near, spare, bands}); \
    }                                                                                                                  \
    KERNEL(name)

// A thread a meshlet of one quad, or of a row of quads.
#define RASTERIZE_ROWS(name, CLASS)                                                                                    \
    extern "C" __global__ void __launch_bounds__(THREADS, BLOCKS)                                                      \
        name(GEOMETRY, Count, Buffer<const uint32_t> numbers, Buffer<uint32_t> wide, Buffer<uint32_t> counts,          \
             Buffer<Word> near, Buffer<Word>, const __grid_constant__ bands::Bands) {                                  \
        const Geometry in = GEOMETRY_ARGUMENTS;                                                                        \
        const uint32_t length = rasterize::before(counts, rasterize::CLASS, rasterize::BINS);                       \
        for (uint32_t k = blockIdx.x * THREADS + threadIdx.x; k < length; k += gridDim.x * THREADS) {                  \
            const uint32_t number = numbers[k];                                                                        \
            const Meshlet m = in.meshlets[number];                                                                     \
            if (!rasterize::strip(in, number, m, in.patches[m.patch], near)) {                                         \
                rasterize::hand_on(wide, counts, number);                                                              \
            }                                                                                                          \
        }                                                                                                              \
    }                                                                                                                  \
    KERNEL(name)

RASTERIZE_ROWS(rasterize_corners, CORNERS)
RASTERIZE_ROWS(rasterize_strips, STRIPS)
RASTERIZE(stroke_corners, STROKES, 1, 4, CORNERS)
// Eight lanes a meshlet of up to 16 vertices.
RASTERIZE(stroke_strips, STROKES, 8, 16, STRIPS)
RASTERIZE(rasterize_narrow, TRIANGLES, 8, 16, NARROW)
RASTERIZE(stroke_narrow, STROKES, 8, 16, NARROW)
// A warp a meshlet.
RASTERIZE(rasterize_wide, TRIANGLES, 32, 64, WIDE)
RASTERIZE(stroke_wide, STROKES, 32, 64, WIDE)

// What was handed on, a warp a band.
extern "C" __global__ void __launch_bounds__(THREADS)
    rasterize_bands(GEOMETRY, Count, Buffer<Word> near, const __grid_constant__ bands::Bands bands) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    bands::for_all(bands, [&](const Band &band) {
        const Meshlet m = in.meshlets[band.meshlet];
        const Corners c = topology::corners(in, m, topology::triangle(m, in.patches[m.patch].diagonal, band.triangle));
        const PixelBox box = bands::box_in(coverage::box_of(view, c), band);
        const Word id = topology::word(0.0f, band.meshlet, band.triangle);
        coverage::each(box, c, id, threadIdx.x % 32, 32, [&](int x, int y, Word word) {
            keep_larger(near, uint32_t(y) * view.size[0] + x, word);
        });
    });
}
KERNEL(rasterize_bands)
