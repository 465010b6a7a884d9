// shade: the exact surface under every pixel, and its colour (DESIGN section 4; ETER's SHD). Twin of src/stages/shade.rs.
#include "interpolate.cuh"
#include "light.cuh"
#include "shading.cuh"

namespace shade {

struct Surfel {
    refinement::Refined refined;
    uint32_t patch;
    float depth;
};

// The surface of a word at a pixel, from the parameters `start` if there are any, else from those of its triangle.
static __device__ __forceinline__ Surfel at(const View &view, const Geometry &in, Word word, uint32_t pixel,
                                            const float *start) {
    const int x = pixel % view.size[0], y = pixel / view.size[0];
    const Meshlet m = in.meshlets[topology::meshlet_of(word)];
    float2 from;
    if (start != nullptr) {
        from = make_float2(start[0], start[1]);
    } else {
        from = interpolate::at(in, in.patches[m.patch], m, topology::index_of(word), x, y);
    }
    const Surface surface = Surface::of(view, in, m.patch, false);
    const float2 target = refinement::target(view, in.leaves[m.patch], x, y);
    Surfel s;
    s.refined = refinement::refine(surface, view.refine, from.x, from.y, target.x, target.y);
    s.patch = m.patch;
    s.depth = shading::stored_depth(view, surface.depth_origin + s.refined.point.z);
    return s;
}

// A pixel's parameters and its colour, linear RGB.
struct Image {
    Buffer<float2> parameters;
    Buffer<float> colors;

    __device__ __forceinline__ void write(const View &view, const Geometry &in, uint32_t pixel, const Surfel &s) const {
        parameters[pixel] = make_float2(s.refined.s, s.refined.t);
        const Leaf &leaf = in.leaves[s.patch];
        const lighting::Light light =
            lighting::at(view, leaf, s.refined.point, pixel % view.size[0], pixel / view.size[0]);
#pragma unroll
        for (int c = 0; c < 3; c++) {
            colors[i64(pixel) * 3 + c] = leaf.color[c] * light.diffuse + light.specular;
        }
    }
};

} // namespace shade

// Every drawn pixel but those that fill took (`taken`: by pixel their number in its list). Pixels in doubt are listed as far
// as there is room, and counted; room 0: none is in doubt.
extern "C" __global__ void __launch_bounds__(THREADS)
    shade_pixels(GEOMETRY, Buffer<const Word> near, Buffer<const uint32_t> taken, Buffer<float2> parameters,
                 Buffer<float> colors, uint32_t room, Buffer<Filled> doubts, Buffer<uint64_t> counted) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t pixel = blockIdx.x * blockDim.x + threadIdx.x;
    if (pixel >= view.size[0] * view.size[1] || near[pixel] == 0 || taken[pixel] != shading::NO_SLOT) {
        return;
    }
    const Word word = near[pixel];
    const shade::Surfel s = shade::at(view, in, word, pixel, nullptr);
    shade::Image{parameters, colors}.write(view, in, pixel, s);
    if (room == 0) {
        return;
    }
    const int hidden = in.patches[s.patch].hidden;
    const uint32_t kind = shading::doubt(view, in.leaves[s.patch], hidden, word, s.refined, s.depth);
    if (kind == DOUBT_NONE) {
        return;
    }
    const uint64_t place = counts::next(counted[0]);
    if (place < room) {
        Filled f = {};
        f.near = topology::with_depth(word, s.depth);
        f.pixel = pixel;
        f.behind = shading::behind(view, kind, s.depth);
        f.has_start = kind == DOUBT_DEEP;
        f.start[0] = s.refined.s;
        f.start[1] = s.refined.t;
        f.winner = 0xffffffffu;
        doubts[place] = f;
    }
}
KERNEL(shade_pixels)

// Pixels that settle found a surface for, from its parameters: their triangles would lead astray near a silhouette.
extern "C" __global__ void __launch_bounds__(THREADS)
    shade_filled(GEOMETRY, Buffer<const Word> near, Buffer<const Filled> filled, Count count,
                 Buffer<float2> parameters, Buffer<float> colors) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const Filled f = filled[k];
    if (!f.has_start) {
        return;
    }
    const shade::Surfel s = shade::at(view, in, near[f.pixel], f.pixel, f.start);
    shade::Image{parameters, colors}.write(view, in, f.pixel, s);
}
KERNEL(shade_filled)

// Other ways to fill: what refinement leaves beyond half a pixel goes back to N. `best` is 1 for pixels that stay.
extern "C" __global__ void __launch_bounds__(THREADS, 4)
    shade_refuse(GEOMETRY, Buffer<Word> near, Buffer<Filled> filled, Count count) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t k = blockIdx.x * blockDim.x + threadIdx.x;
    if (k >= count.get()) {
        return;
    }
    const uint32_t pixel = filled[k].pixel;
    const shade::Surfel s = shade::at(view, in, near[pixel], pixel, nullptr);
    const bool stays = s.refined.residual <= shading::HALF_PIXEL;
    filled[k].best = stays;
    if (!stays) {
        near[pixel] = filled[k].near;
    }
}
KERNEL(shade_refuse)
