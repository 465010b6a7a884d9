// What the finished frame shows, by pixel, for whoever asks it: `Frame::pixel`.
#include "interpolate.cuh"

extern "C" __global__ void __launch_bounds__(THREADS)
    shown_pixels(GEOMETRY, Buffer<const Word> near, Buffer<const float2> parameters,
                 Buffer<Shown> out) {
    const Geometry in = GEOMETRY_ARGUMENTS;
    const uint32_t pixel = blockIdx.x * THREADS + threadIdx.x;
    if (pixel >= view.size[0] * view.size[1] || near[pixel] == 0) {
        return;
    }
    const Word word = near[pixel];
    const Meshlet m = in.meshlets[topology::meshlet_of(word)];
    const Patch &patch = in.patches[m.patch];
    const Leaf &leaf = in.leaves[m.patch];
    const float2 before =
        interpolate::at(in, patch, m, topology::index_of(word), pixel % view.size[0], pixel / view.size[0]);
    const float2 after = parameters[pixel];
    Shown shown;
    shown.interpolated[0] = leaf.corner[0] + double(before.x) * leaf.extent[0];
    shown.interpolated[1] = leaf.corner[1] + double(before.y) * leaf.extent[1];
    shown.stored[0] = leaf.corner[0] + double(after.x) * leaf.extent[0];
    shown.stored[1] = leaf.corner[1] + double(after.y) * leaf.extent[1];
    shown.instance = patch.instance;
    shown.patch = patch.source;
    out[pixel] = shown;
}
KERNEL(shown_pixels)
