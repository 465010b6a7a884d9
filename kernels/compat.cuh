// The one header that kernels include. The same .cu file is built by nvcc for GPUs and by a C++20 compiler for CPUs, where
// kernels/host runs it. What differs between the two has a name here; all else is plain CUDA C++.
//
//   KERNEL(name)                   after the definition of an extern "C" kernel: it can be launched by name
//   SHARED(float4, tile, [64]);    __shared__ float4 tile[64]; on the CPU indices are checked and blocks start on poison
//   DYNAMIC_SHARED(T, name)        the block's dynamic shared memory
//   Buffer<T>                      T * into global memory; on the CPU it knows its allocation and checks each index
//   Span<T>                        T * into shared memory, for functions that get a part of it; checked on the CPU
//   racy_load(&word)               a plain load beside atomics
//   as<U>(pointer), raw(pointer)   reinterpret a Buffer or Span; take the plain, unchecked pointer
#pragma once

#ifdef __CUDACC__

#include <cstdint>
#include <cuda_fp16.h>
#define KERNEL(name)
#define SHARED(T, name, ...) __shared__ T name __VA_ARGS__
#define DYNAMIC_SHARED(T, name)                                         \
  extern __shared__ __align__(16) unsigned char dynamic_shared_bytes[]; \
  T *name = reinterpret_cast<T *>(dynamic_shared_bytes)
template <class T> using Buffer = T *;
template <class T> using Span = T *;
template <class U, class T> static __device__ __forceinline__ U *as(T *p) { return reinterpret_cast<U *>(p); }
template <class T> static __device__ __forceinline__ T *raw(T *p) { return p; }
#define HP_SITE
#define HP_SITE_ONLY

#else

#include "host/cuda.h"
// Where a kernel calls: wrappers of collectives pass it on, so that a diagnosis names the kernel's line.
#define HP_SITE , hp::Site site = hp::Site::current()
#define HP_SITE_ONLY hp::Site site = hp::Site::current()

#endif

// A plain load that may race with atomics, as the look at a depth before the atomic that would lose; any earlier value will
// do. Race detectors must not complain of it.
template <class T> static __device__ __forceinline__ T racy_load(const T *p) {
#ifdef __CUDACC__
  return *p;
#else
  return __atomic_load_n(p, __ATOMIC_RELAXED);
#endif
}

// ---- numbers

// Two halves in a register, the first one in the low bits.
static __device__ __forceinline__ uint32_t pack_half2(float low, float high) {
#ifdef __CUDACC__
  __half2 h = __floats2half2_rn(low, high);
  return *reinterpret_cast<uint32_t *>(&h);
#else
  return hp::half_bits(low) | (uint32_t)hp::half_bits(high) << 16;
#endif
}

// The two halves of a register.
static __device__ __forceinline__ float2 unpack_half2(uint32_t bits) {
#ifdef __CUDACC__
  return __half22float2(*reinterpret_cast<const __half2 *>(&bits));
#else
  return make_float2(hp::half_value((uint16_t)bits), hp::half_value((uint16_t)(bits >> 16)));
#endif
}

// Bits of the nearest tf32 number, ties away from zero.
static __device__ __forceinline__ uint32_t to_tf32(float x) {
#ifdef __CUDACC__
  uint32_t bits;
  asm("cvt.rna.tf32.f32 %0, %1;" : "=r"(bits) : "f"(x));
  return bits;
#else
  return hp::tf32_bits(x);
#endif
}

// 1 / x by MUFU.RCP, at most 1 ulp off and flushing subnormals; the CPU divides, so they may differ in the last bit.
static __device__ __forceinline__ float approximate_reciprocal(float x) {
#ifdef __CUDACC__
  float r;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(r) : "f"(x));
  return r;
#else
  return 1.0f / x;
#endif
}

// ---- tensor cores: D = A B + C, sums in f32; a warp together. Lane l is (g, t) = (l / 4, l % 4), indices are (row, column).
// C and D, 16 x 8: [0] (g, 2t)  [1] (g, 2t + 1)  [2] (g + 8, 2t)  [3] (g + 8, 2t + 1)

// A, 16 x 8, two halves a register: [0] (g, 2t..)  [1] (g + 8, 2t..).  B, 8 x 8: [0] (2t.., g)
static __device__ __forceinline__ void mma_m16n8k8_f16(float (&d)[4], const uint32_t (&a)[2], const uint32_t (&b)[1],
                                                       const float (&c)[4] HP_SITE) {
#ifdef __CUDACC__
  asm volatile("mma.sync.aligned.m16n8k8.row.col.f32.f16.f16.f32 {%0,%1,%2,%3},{%4,%5},{%6},{%7,%8,%9,%10};"
               : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3])
               : "r"(a[0]), "r"(a[1]), "r"(b[0]), "f"(c[0]), "f"(c[1]), "f"(c[2]), "f"(c[3]));
#else
  hp::mma(hp::Tile::f16_k8, d, a, b, c, site);
#endif
}

// A, 16 x 16: [0] (g, 2t..)  [1] (g + 8, 2t..)  [2] (g, 2t + 8..)  [3] (g + 8, 2t + 8..).  B, 16 x 8: [0] (2t.., g)
// [1] (2t + 8.., g)
static __device__ __forceinline__ void mma_m16n8k16_f16(float (&d)[4], const uint32_t (&a)[4], const uint32_t (&b)[2],
                                                        const float (&c)[4] HP_SITE) {
#ifdef __CUDACC__
  asm volatile("mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%0,%1,%2,%3},{%4,%5,%6,%7},{%8,%9},{%10,%11,%12,%13};"
               : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3])
               : "r"(a[0]), "r"(a[1]), "r"(a[2]), "r"(a[3]), "r"(b[0]), "r"(b[1]), "f"(c[0]), "f"(c[1]), "f"(c[2]),
                 "f"(c[3]));
#else
  hp::mma(hp::Tile::f16_k16, d, a, b, c, site);
#endif
}

// A, 16 x 16, of each four columns two: [0] (g, two of 4t..)  [1] (g + 8, two of 4t..).  B as above. `metadata`, the first
// lane's of each four: rows g and g + 8 in 16 bits each, four bits for each four columns, the two columns, smaller one first.
static __device__ __forceinline__ void mma_sp_m16n8k16_f16(float (&d)[4], const uint32_t (&a)[2], const uint32_t (&b)[2],
                                                           const float (&c)[4], uint32_t metadata HP_SITE) {
#ifdef __CUDACC__
  asm volatile("mma.sp::ordered_metadata.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 "
               "{%0,%1,%2,%3},{%4,%5},{%6,%7},{%8,%9,%10,%11},%12,0x0;"
               : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3])
               : "r"(a[0]), "r"(a[1]), "r"(b[0]), "r"(b[1]), "f"(c[0]), "f"(c[1]), "f"(c[2]), "f"(c[3]), "r"(metadata));
#else
  hp::mma(hp::Tile::f16_k16_sparse, d, a, b, c, site, metadata);
#endif
}

// A, 16 x 8, tf32: [0] (g, t)  [1] (g + 8, t)  [2] (g, t + 4)  [3] (g + 8, t + 4).  B, 8 x 8: [0] (t, g)  [1] (t + 4, g)
static __device__ __forceinline__ void mma_m16n8k8_tf32(float (&d)[4], const uint32_t (&a)[4], const uint32_t (&b)[2],
                                                        const float (&c)[4] HP_SITE) {
#ifdef __CUDACC__
  asm volatile("mma.sync.aligned.m16n8k8.row.col.f32.tf32.tf32.f32 {%0,%1,%2,%3},{%4,%5,%6,%7},{%8,%9},{%10,%11,%12,%13};"
               : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3])
               : "r"(a[0]), "r"(a[1]), "r"(a[2]), "r"(a[3]), "r"(b[0]), "r"(b[1]), "f"(c[0]), "f"(c[1]), "f"(c[2]),
                 "f"(c[3]));
#else
  hp::mma(hp::Tile::tf32_k8, d, a, b, c, site);
#endif
}
