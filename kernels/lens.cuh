// From a patch's own coordinates to pixel-homogeneous ones, in f64. Twin of src/stages/lens.rs, where everything is
// explained.
#pragma once
#include "vector.cuh"

namespace lens {

// The map of one patch: rows give X, Y, Z of a local homogeneous point; the camera's axes in the patch's own coordinates.
struct PatchMap {
    Vec4 rows[3];
    Vec3 axes[3];
};

// A control net, v innermost.
struct Net {
    Buffer<const ControlPoint> points;
    int degree_u, degree_v;

    __device__ __forceinline__ int count() const { return (degree_u + 1) * (degree_v + 1); }
    __device__ __forceinline__ Vec4 at(int k) const {
        const ControlPoint p = points[k];
        return {p.x, p.y, p.z, p.w};
    }
    __device__ __forceinline__ Vec4 at(int i, int j) const { return at(i * (degree_v + 1) + j); }
    // In space.
    __device__ __forceinline__ Vec3 place(int k) const {
        const Vec4 p = at(k);
        return truncated(p) / p.w;
    }
};

static __device__ __forceinline__ PatchMap patch_map(const View &view, const SceneInstance &instance, Vec3 origin) {
    const Vec3 x = load_vector(instance.matrix[0]), y = load_vector(instance.matrix[1]), z = load_vector(instance.matrix[2]);
    const Vec3 moved = x * origin.x + y * origin.y + z * origin.z + load_vector(instance.translation);
    const Vec3 offset = moved - load_vector(view.eye);
    PatchMap map;
#pragma unroll
    for (int k = 0; k < 3; k++) {
        const Vec3 q = load_vector(view.axes[k]);
        const double factor = k < 2 ? view.scale : 1.0;
        const Vec3 axis = {dot(x, q), dot(y, q), dot(z, q)};
        map.axes[k] = axis;
        map.rows[k] = {axis.x * factor, axis.y * factor, axis.z * factor, dot(q, offset) * factor};
    }
    return map;
}

static __device__ __forceinline__ Vec4 apply(const PatchMap &map, Vec4 p) {
    return {dot(map.rows[0], p), dot(map.rows[1], p), dot(map.rows[2], p), p.w};
}

// The denominator of the projection.
static __device__ __forceinline__ double denominator(const View &view, Vec4 p) { return view.perspective ? p.z : p.w; }

// Half the image in pixels.
static __device__ __forceinline__ double half_image(const View &view, int axis) { return double(view.size[axis]) * 0.5; }

// Size of a pixel in model units at camera depth z.
static __device__ __forceinline__ double pixel_size(const View &view, double z) {
    return view.perspective ? z / view.scale : 1.0 / view.scale;
}

// Mirrors: the camera's axes turn over.
static __device__ __forceinline__ bool mirrors(const PatchMap &map) {
    return dot(cross(map.axes[0], map.axes[1]), map.axes[2]) < 0.0;
}

// The n-th root of a number that is at least 1: `root` in src/geometry/root.rs.
static __device__ inline double root(double a, int n) {
    if (!(a > 1.0 && a <= 1.7976931348623157e308)) {
        return a > 1.0 ? a : 1.0;
    }
    const double degree = n;
    const int exponent = int(__double_as_longlong(a) >> 52) - 1022;
    double power = 1.0;
    for (int k = 0; k < exponent / n; k++) {
        power *= 2.0;
    }
    double found = power * (1.0 + double(exponent % n) / degree);
    while (true) {
        power = 1.0;
        for (int k = 1; k < n; k++) {
            power *= found;
        }
        const double next = found - (found - a / power) / degree;
        if (!(next < found)) {
            return found;
        }
        found = next;
    }
}

} // namespace lens
