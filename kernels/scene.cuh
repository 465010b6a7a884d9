// The scene in device memory: `SceneOnDevice` in src/cuda/scene.rs.
#pragma once
#include "lens.cuh"
#include "trim_tree.cuh"

namespace scene {

struct Scene {
    Buffer<const ScenePatch> patches;
    Buffer<const ControlPoint> points;
    Buffer<const SceneInstance> instances;
    // Of all faces, in order; then the faces that some instance colours, in lists.
    Buffer<const FaceColor> faces;
    Buffer<const FaceColor> colors;
    trims::Trims trims;
};

// The instance that draws an item: the last one that starts no later.
static __device__ __forceinline__ uint32_t instance_of(const Scene &scene, uint32_t instances, uint32_t item) {
    uint32_t low = 0, high = instances;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (scene.instances[middle].first_item <= item) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

static __device__ __forceinline__ lens::Net net_of(const Scene &scene, const ScenePatch &patch) {
    return {scene.points + patch.points, patch.degree[0], patch.degree[1]};
}

// The point of the plane of its face's trims for one of the patch's unit square.
static __device__ __forceinline__ trims::PlanePoint to_plane(const ScenePatch &patch, double u, double v) {
    return {patch.domain[0][0] + (patch.domain[0][1] - patch.domain[0][0]) * u,
            patch.domain[1][0] + (patch.domain[1][1] - patch.domain[1][0]) * v};
}

// Which way a patch's visible side lies: 1 along S_u x S_v, -1 against it, 0: both sides can be seen.
static __device__ __forceinline__ int visible_side(const Rules &rules, const ScenePatch &patch) {
    const bool automatic = rules.cull == CULL_AUTO;
    if (rules.cull == CULL_OFF || (automatic && (patch.sides == SIDES_BOTH || !rules.whole))) {
        return 0;
    }
    return patch.sides == SIDES_INSIDE ? -1 : 1;
}

// What one drawn patch is coloured: as the instance says of its face, or of the whole, else as the face is.
static __device__ inline FaceColor color_of(const Scene &scene, const SceneInstance &instance, uint32_t face) {
    uint32_t low = instance.first_color, high = instance.first_color + instance.colors;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        const FaceColor color = scene.colors[middle];
        if (color.face == face) {
            return color;
        }
        if (color.face < face) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    if (instance.has_color) {
        return {face, {instance.color[0], instance.color[1], instance.color[2]}};
    }
    return scene.faces[face];
}

} // namespace scene
