// What shade and settle have in common: stored depths, and how far off they may be. Twin of `Shader` in src/stages/shade.rs.
#pragma once
#include "newton.cuh"

namespace shading {

// Pixels between a pixel centre and a projected surface point that count as none.
constexpr float EXACT = 1.0f / 128.0f;
// Pixels that are in no list: the others have their place in it, from 1.
constexpr uint32_t NO_SLOT = 0;
// What the contract allows a filled pixel.
constexpr float HALF_PIXEL = 0.5f;
// Of stored depths, as a share of the camera depth (perspective) or of the depth range.
constexpr double DEPTH_ROUNDING = 8.0 * 1.1920928955078125e-7;
// Parameters so near to a patch's border are on it.
constexpr double BORDER = 1e-6;

static __device__ __forceinline__ float stored_depth(const View &view, float z) {
    return view.perspective ? view.near_f32 / z : 1.0f - (z - view.near_f32) / float(view.extent);
}

static __device__ __forceinline__ double pixel_size(const View &view, double z) {
    return view.perspective ? z / view.scale : 1.0 / view.scale;
}

// A stored depth that is nearer by so many depth tolerances; 0 for background.
static __device__ __forceinline__ float nearer_by_tolerance(const View &view, float stored, double times) {
    if (stored == 0.0f) {
        return 0.0f;
    }
    const double z = view.perspective ? view.near / double(stored) : view.near + (1.0 - double(stored)) * view.extent;
    return stored_depth(view, float(z - times * view.depth_tolerance * pixel_size(view, z)));
}

// A stored depth, farther by so many model units.
static __device__ __forceinline__ double farther(const View &view, float stored, double by) {
    const double depth = stored;
    return view.perspective ? depth / (1.0 + depth * by / view.near) : depth - by / view.extent;
}

// The exact point is not where the grid's depth said, or not under the pixel's centre: on steep surfaces half a pixel is
// many pixels deep, and the depth test was not fair.
static __device__ __forceinline__ uint32_t doubt(const View &view, const Leaf &leaf, int hidden, Word word,
                                                 const refinement::Refined &r, float depth) {
    const double shown = topology::depth_of(word);
    const double pixel = view.perspective ? shown / view.scale : 1.0 / (view.scale * view.extent);
    const double range = view.perspective ? shown : 1.0;
    if (!(depth > 0.0f && depth <= refinement::LARGEST)) {
        return DOUBT_NONE;
    }
    if (r.residual > EXACT) {
        const double u = leaf.corner[0] + double(r.s) * leaf.extent[0], v = leaf.corner[1] + double(r.t) * leaf.extent[1];
        const bool ended = !(u >= BORDER && u <= 1.0 - BORDER) || !(v >= BORDER && v <= 1.0 - BORDER);
        // As far as the model's own gap reaches, the border stands for what is missing.
        return ended && r.residual > float(leaf.gaps[1]) + EXACT ? DOUBT_ENDED : DOUBT_BESIDE;
    }
    if (r.faces_away(hidden)) {
        return DOUBT_BESIDE;
    }
    const double off = fabs(double(depth) - shown);
    return off > view.depth_tolerance * pixel + DEPTH_ROUNDING * range ? DOUBT_DEEP : DOUBT_NONE;
}

// Stored depth that another surface has to be nearer than, to take a pixel that shows `depth` exactly.
static __device__ __forceinline__ float behind(const View &view, uint32_t doubt, float depth) {
    switch (doubt) {
    case DOUBT_DEEP: return nearer_by_tolerance(view, depth, 1.0);
    case DOUBT_BESIDE: return nearer_by_tolerance(view, depth, -1.0);
    default: return 0.0f;
    }
}

} // namespace shading
