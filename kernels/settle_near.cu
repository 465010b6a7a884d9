// Part of shade: which triangles come near to given pixels, and so high there that their surface may be nearer to the eye
// than some depth. Twin of src/stages/settle_near.rs.
//
// A surface point under a pixel's centre has its triangle's point of the same parameters within the grid's deviation, on
// the screen and in depth. So all triangles are drawn once more, wider by that, on the pixels in question alone: twice,
// first to count each pixel's candidates, then to list them.
#include "outlines.cuh"
#include "shading.cuh"

namespace settle_near {

constexpr int WARPS = THREADS / 32;
// Pixels along one side of a tile; tiles without a pixel in question are passed over.
constexpr int TILE_BITS = 3;
// What rounding may take of a stored depth, as a share of it.
constexpr double ROUNDING = 1e-6;

// The pixels in question: by pixel of the image the number in the list, and by tile whether it has any.
struct Wanted {
    Buffer<const uint32_t> slots;
    Buffer<const uint32_t> tiles;
    Buffer<Filled> pixels;
    // Keys: patch << 32 | lower half of a visibility word; null while candidates are counted.
    Buffer<Word> candidates;
    Buffer<uint32_t> cursors;
};

static __device__ __forceinline__ uint32_t tiles_across(const View &view) {
    return (view.size[0] + (1 << TILE_BITS) - 1) >> TILE_BITS;
}

// A triangle's stored depth, affine on the screen.
struct Plane {
    i64 x, y;
    double depth, slope_x, slope_y;
    // The nearest of its corners.
    double most;
    double reach;

    static __device__ __forceinline__ Plane of(const Triangle &t, i64 reach) {
        const double ux = double(t.x[1] - t.x[0]), uy = double(t.y[1] - t.y[0]);
        const double vx = double(t.x[2] - t.x[0]), vy = double(t.y[2] - t.y[0]);
        const double d = t.depth[0], du = double(t.depth[1]) - d, dv = double(t.depth[2]) - d;
        const double area = double(t.area);
        const double most = fmaxf(fmaxf(t.depth[0], t.depth[1]), t.depth[2]);
        return {t.x[0], t.y[0], d, (du * vy - dv * uy) / area, (dv * ux - du * vx) / area, most, double(reach)};
    }

    // The nearest depth of the triangle within reach of a pixel's centre, or more.
    __device__ __forceinline__ double nearest(int px, int py) const {
        const double dx = double(center_of(px) - x), dy = double(center_of(py) - y);
        const double there = depth + slope_x * dx + slope_y * dy + (fabs(slope_x) + fabs(slope_y)) * reach;
        // Seen edge-on it has no slope.
        const double nearest = there < most ? there : most;
        return nearest + fabs(nearest) * ROUNDING;
    }
};

// The pixel's centre has the triangle within `reach`, in x and in y: the separating axes of the two are the square's sides,
// which are done with, and the edges' normals.
static __device__ __forceinline__ bool within(const Triangle &t, i64 reach, int px, int py) {
    return t.edge(0, center_of(px), center_of(py)) + reach * t.span(0) >= 0 &&
           t.edge(1, center_of(px), center_of(py)) + reach * t.span(1) >= 0 &&
           t.edge(2, center_of(px), center_of(py)) + reach * t.span(2) >= 0;
}

static __device__ __forceinline__ PixelBox box_of(const View &view, const Corners &c, i64 reach) {
    return pixels_in(view, {min3(c.v[0].x, c.v[1].x, c.v[2].x) - reach, max3(c.v[0].x, c.v[1].x, c.v[2].x) + reach},
                     {min3(c.v[0].y, c.v[1].y, c.v[2].y) - reach, max3(c.v[0].y, c.v[1].y, c.v[2].y) + reach});
}

static __device__ __forceinline__ bool any_tile(const View &view, const Wanted &wanted, const PixelBox &box) {
    for (i64 y = box.y.low >> TILE_BITS; y <= box.y.high >> TILE_BITS; y++) {
        for (i64 x = box.x.low >> TILE_BITS; x <= box.x.high >> TILE_BITS; x++) {
            if (wanted.tiles[y * tiles_across(view) + x] != 0) {
                return true;
            }
        }
    }
    return false;
}

static __device__ __forceinline__ void propose(const Wanted &wanted, uint32_t slot, Word key) {
    if (wanted.candidates) {
        const uint32_t place = atomicAdd(&wanted.cursors[slot], 1u);
        wanted.candidates[wanted.pixels[slot].first + place] = key;
    } else {
        atomicAdd(&wanted.pixels[slot].candidates, 1u);
    }
}

// A triangle on the pixels in question of each `step`th column of tiles.
static __device__ __forceinline__ void triangle(const outlines::Drawn &d, const Wanted &wanted, const Corners &c, i64 reach,
                                                uint32_t index, int first, int step) {
    const PixelBox box = box_of(d.view, c, reach);
    const Triangle t = Triangle::of(c);
    const Plane plane = Plane::of(t, reach);
    const Word key = Word(d.m.patch) << 32 | (d.number << INDEX_BITS | index);
    for (i64 ty = box.y.low >> TILE_BITS; ty <= box.y.high >> TILE_BITS; ty++) {
        for (i64 tx = (box.x.low >> TILE_BITS) + first; tx <= box.x.high >> TILE_BITS; tx += step) {
            if (wanted.tiles[ty * tiles_across(d.view) + tx] == 0) {
                continue;
            }
            const int x0 = int(max(box.x.low, tx << TILE_BITS)), x1 = int(min(box.x.high, ((tx + 1) << TILE_BITS) - 1));
            const int y0 = int(max(box.y.low, ty << TILE_BITS)), y1 = int(min(box.y.high, ((ty + 1) << TILE_BITS) - 1));
            for (int y = y0; y <= y1; y++) {
                for (int x = x0; x <= x1; x++) {
                    const uint32_t slot = wanted.slots[y * d.view.size[0] + x];
                    if (slot != shading::NO_SLOT && within(t, reach, x, y) &&
                        plane.nearest(x, y) >
                            shading::farther(d.view, wanted.pixels[slot - 1].behind, d.leaf.deviation[1])) {
                        propose(wanted, slot - 1, key);
                    }
                }
            }
        }
    }
}

} // namespace settle_near

// Marks the pixels of the list in the image and in its tiles.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_mark(const __grid_constant__ View view, Buffer<const Filled> pixels, Count count, Buffer<uint32_t> slots,
                Buffer<uint32_t> tiles) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get()) {
        const uint32_t pixel = pixels[k].pixel, x = pixel % view.size[0], y = pixel / view.size[0];
        slots[pixel] = k + 1;
        const uint32_t tile =
            (y >> settle_near::TILE_BITS) * settle_near::tiles_across(view) + (x >> settle_near::TILE_BITS);
        atomicOr(&tiles[tile], 1u);
    }
}
KERNEL(settle_mark)

// One warp a meshlet; a grid of ceil(room / 4) blocks. `candidates` null: only counts; else `all` of them.
extern "C" __global__ void __launch_bounds__(THREADS, 3)
    settle_find(GEOMETRY, Count count, Buffer<const uint32_t> slots, Buffer<const uint32_t> tiles, Buffer<Filled> pixels,
                Count all, Buffer<Word> candidates, Buffer<uint32_t> cursors) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * settle_near::WARPS + threadIdx.x / 32;
    if (number >= count.get() || (candidates && !all.fits())) {
        return;
    }
    const settle_near::Wanted wanted = {slots, tiles, pixels, candidates, cursors};
    const Meshlet m = in.meshlets[number];
    const Patch &patch = in.patches[m.patch];
    const Leaf &leaf = in.leaves[m.patch];
    SHARED(Vertex, staged, [settle_near::WARPS][64]);
    const Span<Vertex> tile = staged[threadIdx.x / 32];
    const outlines::Group<32> warp = outlines::Group<32>::here();
    outlines::load(warp, in, m, tile);
    const outlines::Drawn d = {view, in, m, patch, leaf, number, tile};
    // Within the model's gap the border stands in for what is missing.
    const double pixels_off = double(leaf.deviation[0]) + leaf.gaps[1] + double(shading::EXACT);
    const i64 reach = i64(ceil(pixels_off * double(SUBPIXELS)));
    const auto corners = [&](int k) { return d.corners(topology::triangle(m, patch.diagonal, k)); };
    outlines::for_all(
        warp, topology::triangles(m),
        [&](int k) {
            const PixelBox box = settle_near::box_of(view, corners(k), reach);
            return box.empty() || !settle_near::any_tile(view, wanted, box) ? 0 : box.pixels();
        },
        [&](int k, int first, int step) { settle_near::triangle(d, wanted, corners(k), reach, k, first, step); });
}
KERNEL(settle_find)

// Gives each pixel its part of the list of candidates; `total`: how many there are.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_allocate(Buffer<Filled> pixels, Count count, Buffer<uint64_t> total) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get()) {
        // Of no use where the total does not fit 32 bits; the host looks at that first.
        pixels[k].first = uint32_t(atomicAdd(counts::word(total[0]), Word(pixels[k].candidates)));
    }
}
KERNEL(settle_allocate)
