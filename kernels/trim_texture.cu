// `--trim texture`: a parity texture for each leaf that loops cut, and the fragments that look it up (Guthe, Balazs & Klein 2005,
// sections 4 and 5.3). Twin of src/stages/trim_texture.rs, where everything is explained; the same operations in the same order.
#include "interpolate.cuh"
#include "outlines.cuh"
#include "trim_cut.cuh"

namespace trim_texture {

constexpr int WARPS = THREADS / 32;
using Warp = outlines::Group<32>;
using trims::WORD;
// Texels a side at most.
constexpr double LARGEST = 8192.0;

// The length of the first derivatives in u and v over the tolerance, from the projected control points.
static __device__ inline void sizes(const View &view, const Patch &patch, Buffer<const Point> net, double (&texels)[2]) {
    const int m = patch.degree[0], n = patch.degree[1];
    const auto weight = [&](const Point &p) {
        return double(view.perspective ? p.z + patch.depth_origin * p.w : p.w);
    };
    double least = INFINITY, most = 0.0;
    for (int k = 0; k < (m + 1) * (n + 1); k++) {
        const double w = weight(net[k]);
        least = lesser(w, least);
        most = larger(w, most);
    }
    const auto apart = [&](int a, int b) {
        const Point p = net[a], q = net[b];
        const double x = double(p.x) / weight(p) - double(q.x) / weight(q);
        const double y = double(p.y) / weight(p) - double(q.y) / weight(q);
        return sqrt(x * x + y * y);
    };
    double length[2] = {0.0, 0.0};
    for (int i = 0; i <= m; i++) {
        for (int j = 0; j <= n; j++) {
            const int here = i * (n + 1) + j;
            length[0] = i < m ? larger(apart(here, here + n + 1), length[0]) : length[0];
            length[1] = j < n ? larger(apart(here, here + 1), length[1]) : length[1];
        }
    }
#pragma unroll
    for (int k = 0; k < 2; k++) {
        texels[k] = larger(ceil(length[k] * double(patch.degree[k]) * most / least / view.tolerance), 1.0);
    }
}

// A whole number as an index up to `limit`: 0 for what is less, or none at all.
static __device__ __forceinline__ uint32_t index(double number, double limit) {
    return number > 0.0 ? uint32_t(min(number, limit)) : 0;
}

// Of each bit the parity of it and all lower ones.
static __device__ __forceinline__ uint32_t parities(uint32_t word) {
#pragma unroll
    for (int step = 1; step < int(WORD); step *= 2) {
        word ^= word << step;
    }
    return word;
}

// Sets a row's texels from one to before another.
static __device__ __forceinline__ void set(Buffer<uint32_t> bits, uint32_t from, uint32_t to) {
    for (uint32_t k = from / WORD; k < (to + WORD - 1) / WORD; k++) {
        const uint32_t low = max(from, k * WORD) - k * WORD, high = min(to - k * WORD, WORD);
        bits[k] |= (~0u >> (WORD - (high - low))) << low;
    }
}

// One row of a leaf's texels.
static __device__ inline void draw_row(const trims::Trims &trims, const Leaf &leaf, const TrimTexture &texture, uint32_t row,
                                       Buffer<uint32_t> bits) {
    const uint32_t across = texture.size[0], words = trims::words_across(texture);
    const double columns = across, rows = texture.size[1];
    for (uint32_t k = 0; k < words; k++) {
        bits[k] = 0;
    }
    const double from = trims::to_plane(leaf, 0.0, double(row) / rows).v, to = trims::to_plane(leaf, 0.0, double(row + 1) / rows).v;
    const double low = min(from, to), high = max(from, to);
    const TrimTree &tree = trims.trees[leaf.tree];
    // One more than the texel that u is on, 0 left of them all.
    const auto behind = [&](double u) {
        return index(floor((u - leaf.plane_origin[0]) / leaf.plane_size[0] * columns) + 1.0, columns + 1.0);
    };
    const trims::Box side = {{tree.low[0], low}, {tree.high[0], low}}, whole = {{tree.low[0], low}, {tree.high[0], high}};
    trims::visit(trims, leaf.tree, side, [&](const TrimClip &clip) {
        if (clip.heights[0] <= low && low < clip.heights[1]) {
            const uint32_t column = trims::crossing(trims::Curve(trims, clip.segment), low, behind);
            if (column < across) {
                bits[column / WORD] ^= 1u << column % WORD;
            }
        }
        return false;
    });
    uint32_t before = 0;
    for (uint32_t k = 0; k < words; k++) {
        const uint32_t word = parities(bits[k]) ^ before;
        bits[k] = word;
        before = 0u - (word >> (WORD - 1));
    }
    trims::visit(trims, leaf.tree, whole, [&](const TrimClip &clip) {
        const trims::Curve curve(trims, clip.segment);
        if (curve.bounds().touches(whole)) {
            const uint32_t a = trims::crossing(curve, low, behind), b = trims::crossing(curve, high, behind);
            const uint32_t first = min(a, b), last = max(a, b);
            if (first <= across && last > 0) {
                set(bits, max(first, 1u) - 1, min(last, across));
            }
        }
        return false;
    });
}

// What a lane found.
struct Looked {
    uint32_t tested, rejected;
};

// Draws the fragments of a triangle that lie on texels that are set.
static __device__ __forceinline__ void triangle(const outlines::Drawn &d, const trims::Trims &trims, int index, int first,
                                                int step, Buffer<Word> near, Looked &looked) {
    const topology::Primitive p = topology::triangle(d.m, d.patch.diagonal, index);
    const Corners corners = d.corners(p);
    const TrimTexture texture = trims.textures[d.m.patch];
    coverage::each(d.view, corners, d.id(index), first, step, [&](int x, int y, Word word) {
        const uint32_t pixel = uint32_t(y) * d.view.size[0] + x;
        if (racy_load(&near[pixel]) >= word) {
            return;
        }
        const float2 s = interpolate::in_triangle(d.patch, d.m, p, corners, center_of(x), center_of(y));
        const bool keeps = trims::contains(trims, texture, s.x, s.y);
        looked.tested++;
        looked.rejected += !keeps;
        if (keeps) {
            keep_larger(near, pixel, word);
        }
    });
}

} // namespace trim_texture

// A thread a leaf: its texels, its rows and the words that they take.
extern "C" __global__ void __launch_bounds__(THREADS)
    texture_sizes(const __grid_constant__ View view, uint32_t leaves, Buffer<const Patch> patches, Buffer<const Leaf> described,
                  Buffer<const Point> nets, Buffer<TrimTexture> textures, Buffer<uint32_t> rows, Buffer<uint32_t> words,
                  Buffer<TextureCounts> counts) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= leaves) {
        return;
    }
    TrimTexture texture = {};
    if (described[k].tree != NO_TREE) {
        double needed[2];
        trim_texture::sizes(view, patches[k], nets + patches[k].net, needed);
        texture.size[0] = uint32_t(min(needed[0], trim_texture::LARGEST));
        texture.size[1] = uint32_t(min(needed[1], trim_texture::LARGEST));
        if (needed[0] > trim_texture::LARGEST || needed[1] > trim_texture::LARGEST) {
            atomicAdd(as<Word>(&counts[0].too_coarse), Word(1));
        }
    }
    textures[k] = texture;
    rows[k] = texture.size[1];
    words[k] = texture.size[1] * trims::words_across(texture);
}
KERNEL(texture_sizes)

// A thread a row of some texture.
extern "C" __global__ void __launch_bounds__(THREADS, 4)
    texture_rows(uint32_t count, uint32_t leaves, const __grid_constant__ trims::Trims trims, Buffer<const Leaf> described,
                 Buffer<TrimTexture> textures, Buffer<const uint32_t> first_rows, Buffer<const uint32_t> first_words,
                 Buffer<uint32_t> texels) {
    const uint32_t number = blockIdx.x * blockDim.x + threadIdx.x;
    if (number >= count) {
        return;
    }
    // The last leaf that begins no later: those without rows begin where the next one does.
    uint32_t low = 0, high = leaves;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        (first_rows[middle] <= number ? low : high) = middle;
    }
    const uint32_t row = number - first_rows[low];
    if (row == 0) {
        textures[low].first = first_words[low];
    }
    TrimTexture texture;
    texture.size[0] = textures[low].size[0];
    texture.size[1] = textures[low].size[1];
    const uint64_t place = first_words[low] + uint64_t(row) * trims::words_across(texture);
    trim_texture::draw_row(trims, described[low], texture, row, texels + place);
}
KERNEL(texture_rows)

// The tested meshlets, by their textures; a grid of ceil(count / 4) blocks.
extern "C" __global__ void __launch_bounds__(THREADS, 2)
    texture_meshlets(GEOMETRY, Count count, const __grid_constant__ trims::Trims trims, Buffer<Word> near,
                     Buffer<TextureCounts> counts) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t number = blockIdx.x * trim_texture::WARPS + threadIdx.x / 32;
    if (number >= count.get() || in.meshlets[number].tested != MESHLET_TESTED) {
        return;
    }
    const Meshlet m = in.meshlets[number];
    const Patch &patch = in.patches[m.patch];
    SHARED(Vertex, tiles, [trim_texture::WARPS][64]);
    const Span<Vertex> tile = tiles[threadIdx.x / 32];
    const trim_texture::Warp warp = trim_texture::Warp::here();
    outlines::load(warp, in, m, tile);
    const outlines::Drawn d = {view, in, m, patch, in.leaves[m.patch], number, tile};
    trim_texture::Looked looked = {0, 0};
    outlines::for_all(
        warp, topology::triangles(m),
        [&](int k) {
            const Corners c = d.corners(topology::triangle(m, patch.diagonal, k));
            return faces_away(c, patch.hidden) ? 0 : outlines::pixels_of(coverage::box_of(view, c));
        },
        [&](int k, int first, int step) { trim_texture::triangle(d, trims, k, first, step, near, looked); });
    const uint32_t tested = __reduce_add_sync(~0u, looked.tested), rejected = __reduce_add_sync(~0u, looked.rejected);
    if (warp.lane == 0 && tested > 0) {
        atomicAdd(as<Word>(&counts[0].tested), Word(tested));
        atomicAdd(as<Word>(&counts[0].rejected), Word(rejected));
    }
}
KERNEL(texture_meshlets)
