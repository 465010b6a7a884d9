// Whether all of a patch faces away. Twin of src/stages/cone.rs, where everything is explained.
#pragma once
#include "lens.cuh"

namespace cone {

// A unit axis and the cosine of the half angle.
struct Cone {
    Vec3 axis;
    double cos;
};

static __device__ __forceinline__ double sine(double cos) { return sqrt(max(1.0 - cos * cos, 0.0)); }

static __device__ __forceinline__ bool is_near(const Cone &a, const Cone &b) {
    const double cos_a = a.cos - 1e-15, cos_b = b.cos - 1e-15;
    const double sin_a = sine(cos_a), sin_b = sine(cos_b);
    const double cos = cos_a * cos_b - sin_a * sin_b;
    const double sin = sin_a * cos_b + cos_a * sin_b;
    return cos_a > 0.0 && cos_b > 0.0 && cos > 0.0 && dot(a.axis, b.axis) > sin + 1e-9;
}

// The eye in local coordinates.
static __device__ __forceinline__ Vec3 eye_of(const lens::PatchMap &map) {
    const Vec3 a = truncated(map.rows[0]), b = truncated(map.rows[1]), c = truncated(map.rows[2]);
    const Vec3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    return (bc * map.rows[0].w + ca * map.rows[1].w + ab * map.rows[2].w) * (-1.0 / dot(a, bc));
}

// The directions from the eye to a patch; the cosine is not positive where they fill more than half a sphere.
static __device__ __forceinline__ Cone of_rays(const lens::Net &net, const lens::PatchMap &map) {
    const Vec3 eye = eye_of(map);
    const int count = net.count();
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < count; k++) {
        const Vec3 d = net.place(k) - eye;
        const double inverse = inverse_length(d);
        sum = sum + (inverse > 0.0 ? d * inverse : Vec3{0.0, 0.0, 0.0});
    }
    const double inverse = inverse_length(sum);
    if (inverse == 0.0) {
        return {sum, -1.0};
    }
    Cone cone = {sum * inverse, 1.0};
    for (int k = 0; k < count; k++) {
        const Vec3 d = net.place(k) - eye;
        const double inverse = inverse_length(d);
        cone.cos = min(cone.cos, dot(inverse > 0.0 ? d * inverse : Vec3{0.0, 0.0, 0.0}, cone.axis));
    }
    return cone;
}

// The one direction of an orthographic view.
static __device__ __forceinline__ Cone of_parallel_rays(const lens::PatchMap &map) {
    const Vec3 along = cross(map.axes[0], map.axes[1]);
    const Vec3 away = along * copysign(1.0, dot(along, map.axes[2]));
    return {away * (1.0 / length(away)), 1.0};
}

// All of a solid's patch faces away from an eye that is outside; `side`: which of its sides can be seen.
static __device__ __forceinline__ bool is_back_patch(const View &view, const ScenePatch &patch, int side,
                                                     const lens::Net &net, const lens::PatchMap &map) {
    if (side == 0 || patch.cone_cos <= 0.0) {
        return false;
    }
    const Cone normals = {load_vector(patch.cone_axis) * double(side), patch.cone_cos};
    return is_near(normals, view.perspective ? of_rays(net, map) : of_parallel_rays(map));
}

} // namespace cone
