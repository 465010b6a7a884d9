// Whether all of a patch faces away, or lies outside the image. Twin of src/stages/cone.rs, where everything is explained.
#pragma once
#include "lens.cuh"

namespace cone {

// Pixels that the image is enlarged by: strokes reach past a patch.
constexpr double MARGIN = 1.0;

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

// The directions from the eye to a ball about a patch's origin; the cosine is not positive where the eye is in it.
static __device__ __forceinline__ Cone of_rays(double radius, const lens::PatchMap &map) {
    const Vec3 eye = eye_of(map);
    const double distance = length(eye);
    const double sin = radius / distance;
    return {eye * (-1.0 / distance), sin < 1.0 ? sqrt(1.0 - sin * sin) : -1.0};
}

// The one direction of an orthographic view.
static __device__ __forceinline__ Cone of_parallel_rays(const lens::PatchMap &map) {
    const Vec3 along = cross(map.axes[0], map.axes[1]);
    const Vec3 away = along * copysign(1.0, dot(along, map.axes[2]));
    return {away * (1.0 / length(away)), 1.0};
}

// A linear form is positive all over a ball about the origin.
static __device__ __forceinline__ bool positive(Vec4 q, double radius) {
    const Vec3 across = truncated(q);
    return q.w > 0.0 && q.w * q.w > dot(across, across) * (radius * radius);
}

// A ball about a patch's origin lies beyond one side of the image, or nearer than what is drawn: `Culler::is_outside`.
static __device__ __forceinline__ bool is_outside(const View &view, double radius, const lens::PatchMap &map) {
    const Vec4 one = {0.0, 0.0, 0.0, 1.0}, none = {-0.0, -0.0, -0.0, -0.0};
    const Vec4 by = view.perspective ? map.rows[2] : one;
    const Vec4 wide = by * (lens::half_image(view, 0) + MARGIN), high = by * (lens::half_image(view, 1) + MARGIN);
    return positive(map.rows[0] - wide, radius) || positive(none - map.rows[0] - wide, radius)
           || positive(map.rows[1] - high, radius) || positive(none - map.rows[1] - high, radius)
           || positive(one * view.near - map.rows[2], radius);
}

// All of a solid's patch faces away from an eye that is outside; `side`: which of its sides can be seen.
static __device__ __forceinline__ bool is_back_patch(const View &view, const ScenePatch &patch, int side,
                                                     const lens::PatchMap &map) {
    if (side == 0 || patch.cone_cos <= 0.0) {
        return false;
    }
    const Cone normals = {load_vector(patch.cone_axis) * double(side), patch.cone_cos};
    return is_near(normals, view.perspective ? of_rays(patch.radius, map) : of_parallel_rays(map));
}

} // namespace cone
