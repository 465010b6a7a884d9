// The light on a pixel: Blinn-Phong by two directional lights. Twin of src/stages/light.rs.
#pragma once
#include "newton.cuh"

namespace lighting {

constexpr float AMBIENT = 0.08f;
constexpr float SPECULAR = 0.25f;
// The shine is to the power of two to this.
constexpr int SQUARINGS = 5;

static __device__ __forceinline__ float dot(float3 a, float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// A direction of unit length, or the other where there is none: of zero length, or beyond what f32 holds.
static __device__ __forceinline__ float3 unit(float3 v, float3 other) {
    const float by = 1.0f / sqrtf(dot(v, v));
    const bool known = by > 0.0f && by <= refinement::LARGEST;
    return known ? make_float3(v.x * by, v.y * by, v.z * by) : other;
}

struct Light {
    // Times the surface's colour, and of the lights' own colour, white.
    float diffuse, specular;
};

// By a light in camera axes (x right, y down, z away): unit direction towards it, and strength.
static __device__ __forceinline__ void add(Light &light, float3 normal, float3 towards_eye, float3 towards, float strength) {
    light.diffuse += larger(dot(normal, towards), 0.0f) * strength;
    const float3 half =
        unit(make_float3(towards.x + towards_eye.x, towards.y + towards_eye.y, towards.z + towards_eye.z), make_float3(0, 0, 0));
    float shine = larger(dot(normal, half), 0.0f);
    for (int k = 0; k < SQUARINGS; k++) {
        shine *= shine;
    }
    light.specular += shine * (strength * SPECULAR);
}

// A patch's affine axes are M times camera axes, M = [[f, 0, -cx], [0, f, -cy], [0, 0, 1]] in perspective and diag(s, s, 1)
// in orthographic views: normals go back with the transpose of M.
static __device__ __forceinline__ Light at(const View &view, const Leaf &leaf, const PatchPoint &point, int x, int y) {
    // Only the direction counts: M over its scale keeps numbers near one.
    const float inverse = 1.0f / float(view.scale);
    float3 ray = make_float3(0.0f, 0.0f, 1.0f);
    if (view.perspective) {
        ray.x = (float(x) + 0.5f - float(double(view.size[0]) * 0.5)) * inverse;
        ray.y = (float(y) + 0.5f - float(double(view.size[1]) * 0.5)) * inverse;
        ray = unit(ray, make_float3(0.0f, 0.0f, 1.0f));
    }
    const float3 towards_eye = make_float3(-ray.x, -ray.y, -ray.z);
    const float3 n = unit(make_float3(point.normal[0], point.normal[1], point.normal[2]), make_float3(0, 0, 0));
    float z = n.z * inverse;
    if (view.perspective) {
        z -= (n.x * float(leaf.center[0]) + n.y * float(leaf.center[1])) * inverse;
    }
    float3 normal = unit(make_float3(n.x, n.y, z), towards_eye);
    if (dot(normal, ray) > 0.0f) {
        normal = make_float3(-normal.x, -normal.y, -normal.z);
    }
    Light light = {AMBIENT, 0.0f};
    add(light, normal, towards_eye, make_float3(-0.45065394f, -0.65094453f, -0.6108864f), 0.85f);
    add(light, normal, towards_eye, make_float3(0.751882f, 0.10025094f, -0.6516311f), 0.30f);
    return light;
}

} // namespace lighting
