// Part of shade: which of the filled pixels were gaps, now that the exact surface is asked (DESIGN section 4, "Refinement").
// Twin of src/stages/settle.rs.
//
// A gap between two grids is no gap of the surface: some patch lies exactly under its pixel's centre. A stroke that sticks
// out past the outline of a surface has none there.
#include "interpolate.cuh"
#include "shading.cuh"
#include "trim_cut.cuh"

namespace settle {

// Starts nearer to each other than this part of a quad, in both parameters, lead to the same point: nearest points, which
// neighbouring triangles have in common, and corners.
constexpr float POINTS_APART = 0.25f;
constexpr float CORNERS_APART = 0.5f;
// Starts a candidate has at most: its nearest point and its corners.
constexpr uint32_t STARTS = 4;

// Ascending, by Shell's method: short lists, and no worse than n^1.5 for long ones.
static __device__ __forceinline__ void sort(Buffer<Word> keys, uint32_t count) {
    uint32_t gap = 1;
    while (gap < count / 3) {
        gap = 3 * gap + 1;
    }
    for (; gap > 0; gap /= 3) {
        for (uint32_t i = gap; i < count; i++) {
            const Word key = keys[i];
            uint32_t j = i;
            for (; j >= gap && keys[j - gap] > key; j -= gap) {
                keys[j] = keys[j - gap];
            }
            keys[j] = key;
        }
    }
}

// One pixel's starts.
struct Starts {
    Buffer<Start> list;
    uint32_t count;
    // Where those of the present patch begin.
    uint32_t first;
    uint32_t slot;
    // The pixel's own point, if it is of the present patch: known already.
    bool has_shown;
    float2 shown;

    __device__ __forceinline__ bool is_new(const Patch &patch, float2 p, float apart) const {
        const auto near = [&](float s, float t) {
            return fabsf(s - p.x) * float(patch.quads[0]) <= apart && fabsf(t - p.y) * float(patch.quads[1]) <= apart;
        };
        if (has_shown && near(shown.x, shown.y)) {
            return false;
        }
        for (uint32_t k = first; k < count; k++) {
            if (near(list[k].parameters[0], list[k].parameters[1])) {
                return false;
            }
        }
        return true;
    }

    __device__ __forceinline__ void push(uint32_t patch, uint32_t triangle, float2 p) {
        Start start = {{p.x, p.y}, triangle, patch, slot, 0.0f};
        list[count++] = start;
    }
};

// A candidate's starts: from the nearest point, and where the surface may fold over from the corners too.
static __device__ __forceinline__ void add(const View &view, const Geometry &in, Starts &starts, Word key, uint32_t pixel) {
    const uint32_t triangle = uint32_t(key), number = uint32_t(key >> 32);
    const Patch patch = in.patches[number];
    const Meshlet m = in.meshlets[topology::meshlet_of(triangle)];
    const uint32_t index = topology::index_of(triangle);
    const int x = pixel % view.size[0], y = pixel / view.size[0];
    const float2 nearest = interpolate::at(in, patch, m, index, x, y);
    if (starts.is_new(patch, nearest, POINTS_APART)) {
        starts.push(number, triangle, nearest);
    }
    const topology::Primitive p = topology::primitive(m, patch.diagonal, index);
    if (!stroke::may_fold(topology::corners(in, m, p), in.leaves[number].deviation[0])) {
        return;
    }
#pragma unroll
    for (int k = 0; k < 3; k++) {
        const float2 corner = topology::parameters(patch, m, p.corner[k]);
        if (starts.is_new(patch, corner, CORNERS_APART)) {
            starts.push(number, triangle, corner);
        }
    }
}

static __device__ __forceinline__ bool belongs(const trims::Trims &trims, const View &view, const Leaf &leaf, uint32_t number,
                                               const refinement::Refined &r, bool reaching) {
    if (leaf.tree == NO_TREE) {
        return true;
    }
    return reaching ? trims::keeps(trims, view, leaf, number, r) : trims::contains(trims, leaf, r.s, r.t);
}

} // namespace settle

// What the list of filled pixels asks for: a surface that is clearly nearer than N's own.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_ask(const __grid_constant__ View view, Buffer<Filled> pixels, Count count) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k < count.get()) {
        pixels[k].behind = shading::nearer_by_tolerance(view, topology::depth_of(pixels[k].near), 1.0);
        pixels[k].winner = 0xffffffffu;
    }
}
KERNEL(settle_ask)

// The starts of each pixel's candidates, in the same order whatever order these were found in: four places a candidate.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_starts(GEOMETRY, Buffer<const Filled> pixels, Count count, Count all, Buffer<Word> candidates, Buffer<Start> starts) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t slot = blockIdx.x * blockDim.x + threadIdx.x;
    if (slot >= count.get() || !all.fits()) {
        return;
    }
    const Filled f = pixels[slot];
    const Buffer<Word> keys = candidates + f.first;
    settle::sort(keys, f.candidates);
    const uint32_t shown = f.has_start ? in.meshlets[topology::meshlet_of(f.near)].patch : NO_PATCH;
    settle::Starts found = {starts + i64(f.first) * settle::STARTS, 0, 0, slot, false, make_float2(f.start[0], f.start[1])};
    uint32_t last = NO_PATCH;
    for (uint32_t k = 0; k < f.candidates; k++) {
        const uint32_t patch = uint32_t(keys[k] >> 32);
        if (patch != last) {
            found.first = found.count;
            found.has_shown = patch == shown;
            last = patch;
        }
        settle::add(view, in, found, keys[k], f.pixel);
    }
    for (uint32_t k = found.count; k < f.candidates * settle::STARTS; k++) {
        found.list[k].patch = NO_PATCH;
    }
}
KERNEL(settle_starts)

// Refines every start; the nearest surface exactly under its pixel's centre wins, among equals the larger word.
// `reaching`: faces reach over the model's gaps; else only what lies under the centre itself counts.
extern "C" __global__ void __launch_bounds__(THREADS, BLOCKS)
    settle_search(GEOMETRY, Buffer<Filled> pixels, Buffer<Start> starts, Count candidates, uint32_t reaching,
                  const __grid_constant__ trims::Trims trims) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= candidates.get() * settle::STARTS || starts[k].patch == NO_PATCH) {
        return;
    }
    const Start start = starts[k];
    const Leaf &leaf = in.leaves[start.patch];
    const Surface surface = Surface::of(view, in, start.patch, true);
    const uint32_t pixel = pixels[start.slot].pixel;
    const float2 target = refinement::target(view, leaf, pixel % view.size[0], pixel / view.size[0]);
    const refinement::Refined r =
        refinement::refine(surface, 1, start.parameters[0], start.parameters[1], target.x, target.y);
    // Where the patch ends within the model's gap, its border stands in for what lies in it.
    const float border = reaching ? float(leaf.gaps[0]) : 0.0f;
    const float depth = shading::stored_depth(view, surface.depth_origin + r.point.z);
    const bool found = r.residual <= fminf(shading::EXACT + border, shading::HALF_PIXEL) &&
                       depth > pixels[start.slot].behind && !r.faces_away(in.patches[start.patch].hidden);
    if (found && settle::belongs(trims, view, leaf, start.patch, r, reaching != 0)) {
        starts[k].parameters[0] = r.s;
        starts[k].parameters[1] = r.t;
        starts[k].depth = depth;
        const Word word = Word(__float_as_uint(depth)) << 32 | start.triangle;
        atomicMax(as<Word>(&pixels[start.slot].best), word);
    }
}
KERNEL(settle_search)

// The first of the starts that found what won.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_winner(Buffer<Filled> pixels, Buffer<const Start> starts, Count candidates) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= candidates.get() * settle::STARTS || starts[k].patch == NO_PATCH || starts[k].depth == 0.0f) {
        return;
    }
    const Start start = starts[k];
    if (pixels[start.slot].best == (Word(__float_as_uint(start.depth)) << 32 | start.triangle)) {
        atomicMin(&pixels[start.slot].winner, k);
    }
}
KERNEL(settle_winner)

// Pixels go to what was found; the others get back what they had, and lose their mark. `start` is that of what was found
// from now on.
extern "C" __global__ void __launch_bounds__(THREADS)
    settle_apply(Buffer<Filled> pixels, Buffer<const Start> starts, Count count, Buffer<Word> near,
                 Buffer<uint32_t> slots) {
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Filled f = pixels[k];
    near[f.pixel] = f.best != 0 ? f.best : f.near;
    pixels[k].has_start = f.best != 0;
    if (f.best == 0) {
        slots[f.pixel] = shading::NO_SLOT;
    } else {
        pixels[k].start[0] = starts[f.winner].parameters[0];
        pixels[k].start[1] = starts[f.winner].parameters[1];
    }
}
KERNEL(settle_apply)
