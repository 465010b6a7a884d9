// CUDA's keywords, vector types and built-in variables.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#define __global__
#define __device__
#define __host__
// A table that kernels only read; the CPU has it once.
#define __constant__
#define __forceinline__ inline __attribute__((always_inline))
#define __noinline__ __attribute__((noinline))
#define __launch_bounds__(...)
#define __grid_constant__
#define __align__(n) alignas(n)
// A prefix can't tell where the variable ends, so its indices could not be checked, nor its memory poisoned between blocks.
#define __shared__ static_assert(false, "write SHARED(type, name, [size]) of compat.cuh instead of __shared__");

struct uint3 {
  unsigned x, y, z;
};
struct dim3 {
  unsigned x, y, z;
  constexpr dim3(unsigned x = 1, unsigned y = 1, unsigned z = 1) : x(x), y(y), z(z) {}
};

#define HP_VECTOR2(T, V)                    \
  struct alignas(2 * sizeof(T)) V##2 {      \
    T x, y;                                 \
  };                                        \
  inline V##2 make_##V##2(T x, T y) { return {x, y}; }
#define HP_VECTOR3(T, V)                                    \
  struct V##3 {                                             \
    T x, y, z;                                              \
  };                                                        \
  inline V##3 make_##V##3(T x, T y, T z) { return {x, y, z}; }
#define HP_VECTOR4(T, V)                                              \
  struct alignas(sizeof(T) > 4 ? 16 : 4 * sizeof(T)) V##4 {           \
    T x, y, z, w;                                                     \
  };                                                                  \
  inline V##4 make_##V##4(T x, T y, T z, T w) { return {x, y, z, w}; }
#define HP_VECTORS(T, V) HP_VECTOR2(T, V) HP_VECTOR3(T, V) HP_VECTOR4(T, V)
HP_VECTORS(float, float)
HP_VECTORS(int, int)
HP_VECTORS(double, double)
HP_VECTORS(short, short)
HP_VECTORS(unsigned char, uchar)
HP_VECTORS(unsigned short, ushort)
HP_VECTORS(unsigned long long, ulonglong)
HP_VECTOR2(unsigned, uint)
HP_VECTOR4(unsigned, uint)
inline uint3 make_uint3(unsigned x, unsigned y, unsigned z) { return {x, y, z}; }
#undef HP_VECTORS
#undef HP_VECTOR4
#undef HP_VECTOR3
#undef HP_VECTOR2

constexpr int warpSize = 32;
#define threadIdx (hp::current->index)
#define blockIdx (hp::grid.block_index)
#define blockDim (hp::grid.block_size)
#define gridDim (hp::grid.size)
