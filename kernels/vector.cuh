// Vectors of doubles, with the operations of the CPU's (glam) in their order: both sides get the same bits.
#pragma once
#include "abi.h"
#include "compat.cuh"

struct Vec3 {
    double x, y, z;
};

static __device__ __forceinline__ Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static __device__ __forceinline__ Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static __device__ __forceinline__ Vec3 operator*(Vec3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
static __device__ __forceinline__ Vec3 operator/(Vec3 a, double s) { return {a.x / s, a.y / s, a.z / s}; }
static __device__ __forceinline__ double dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static __device__ __forceinline__ double length(Vec3 a) { return sqrt(dot(a, a)); }
static __device__ __forceinline__ Vec3 absolute(Vec3 a) { return {fabs(a.x), fabs(a.y), fabs(a.z)}; }

static __device__ __forceinline__ Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

// The other one where a component is not a number.
static __device__ __forceinline__ double lesser(double a, double b) { return a < b ? a : b; }
static __device__ __forceinline__ double larger(double a, double b) { return a > b ? a : b; }
static __device__ __forceinline__ Vec3 lesser(Vec3 a, Vec3 b) { return {lesser(a.x, b.x), lesser(a.y, b.y), lesser(a.z, b.z)}; }
static __device__ __forceinline__ Vec3 larger(Vec3 a, Vec3 b) { return {larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z)}; }

static __device__ __forceinline__ double clamped(double x, double low, double high) {
    return x < low ? low : x > high ? high : x;
}

// One over the length; zero where there is none.
static __device__ __forceinline__ double inverse_length(Vec3 a) {
    const double inverse = 1.0 / length(a);
    return inverse > 0.0 && inverse <= 1.7976931348623157e308 ? inverse : 0.0;
}

static __device__ __forceinline__ Vec3 load_vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

struct Vec4 {
    double x, y, z, w;
};

static __device__ __forceinline__ Vec4 operator+(Vec4 a, Vec4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
static __device__ __forceinline__ Vec4 operator-(Vec4 a, Vec4 b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
static __device__ __forceinline__ Vec4 operator*(Vec4 a, double s) { return {a.x * s, a.y * s, a.z * s, a.w * s}; }
static __device__ __forceinline__ Vec3 truncated(Vec4 a) { return {a.x, a.y, a.z}; }
static __device__ __forceinline__ double dot(Vec4 a, Vec4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }
