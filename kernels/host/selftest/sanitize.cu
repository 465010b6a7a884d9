// What sanitizers must find, and what they must not complain about. Pointers are plain: the shim itself checks nothing here.
#include "compat.cuh"

// Neighbours swap words through shared memory; only __syncwarp makes that safe.
extern "C" __global__ void sanitize_warp(unsigned *out) {
  SHARED(unsigned, s, [64]);
  unsigned t = threadIdx.x;
  s[t] = t;
#ifndef SELFTEST_NO_BARRIER
  __syncwarp();
#endif
  out[blockIdx.x * 64 + t] = s[t ^ 1];
}
KERNEL(sanitize_warp)

// A shuffle is a rendezvous, but it does not order memory.
extern "C" __global__ void sanitize_shuffle(unsigned *out) {
  SHARED(unsigned, s, [64]);
  unsigned t = threadIdx.x;
  s[t] = t;
  unsigned other = __shfl_xor_sync(~0u, t, 1);
#ifndef SELFTEST_NO_BARRIER
  __syncwarp();
#endif
  out[blockIdx.x * 64 + t] = s[other];
}
KERNEL(sanitize_shuffle)

// Blocks that write the same word of global memory; atomics may.
extern "C" __global__ void sanitize_blocks(unsigned *out) {
  if (threadIdx.x) return;
#ifdef SELFTEST_NO_BARRIER
  out[0] += 1;
#else
  atomicAdd(&out[0], 1u);
#endif
}
KERNEL(sanitize_blocks)

// A block publishes data with a fence and a flag, the other one reads it.
extern "C" __global__ void sanitize_fence(unsigned *out) {
  if (threadIdx.x) return;
  out[2 + blockIdx.x] = 7;
#ifndef SELFTEST_NO_BARRIER
  __threadfence();
#endif
  unsigned before = atomicAdd(&out[0], 1u);
#ifndef SELFTEST_NO_BARRIER
  __threadfence();
#endif
  if (before == gridDim.x - 1) out[1] = out[2] + out[3];
}
KERNEL(sanitize_fence)

extern "C" __global__ void sanitize_within(unsigned *out, int n) {
  SHARED(unsigned, s, [64]);
  unsigned *plain = raw(s);
  plain[threadIdx.x] = threadIdx.x;
  __syncthreads();
  out[threadIdx.x] = plain[n - 1 - (int)threadIdx.x];
}
KERNEL(sanitize_within)

extern "C" __global__ void sanitize_beyond_buffer(unsigned *out, int n) {
  __syncthreads();
  if (threadIdx.x == 40) out[n] = 1;  // one past the end
}
KERNEL(sanitize_beyond_buffer)

extern "C" __global__ void sanitize_beyond_shared(unsigned *out, int n) {
  SHARED(unsigned, s, [64]);
  unsigned *plain = raw(s);
  plain[threadIdx.x] = 1;
  __syncthreads();
  out[threadIdx.x] = plain[threadIdx.x + (n == 64 ? 1 : 0)];
}
KERNEL(sanitize_beyond_shared)
