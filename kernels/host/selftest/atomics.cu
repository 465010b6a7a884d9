// Atomics that all threads of all blocks contend for.
#include "compat.cuh"

extern "C" __global__ void selftest_atomics(Buffer<unsigned long long> wide, Buffer<unsigned> narrow, Buffer<float> real) {
  unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  unsigned long long key = (unsigned long long)(i * 2654435761u) << 32 | i;
  atomicMax(&wide[0], key);
  atomicMin(&wide[1], key);
  atomicAdd(&wide[2], (unsigned long long)i << 33);
  atomicXor(&wide[3], key);
  atomicOr(&wide[4], 1ull << (i % 64));
  atomicAnd(&wide[5], ~(1ull << (i % 61)));
  atomicAdd(&narrow[0], i);
  atomicMax(&narrow[1], i * 2654435761u);
  atomicMin(&narrow[2], i * 2654435761u);
  atomicInc(&narrow[3], 99u);
  atomicSub(&narrow[4], 2u);
  // A lock-free maximum, as kernels write it for types that have none.
  unsigned old = racy_load(&narrow[5]);
  while (old < i) {
    unsigned seen = atomicCAS(&narrow[5], old, i);
    if (seen == old) break;
    old = seen;
  }
  atomicAdd(&real[0], 0.5f);
}
KERNEL(selftest_atomics)

// The visibility buffer: many writers a pixel, the largest word wins.
extern "C" __global__ void selftest_visibility(Buffer<unsigned long long> words, int pixels, int rounds) {
  unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  for (int r = 0; r < rounds; r++) {
    unsigned h = (i * 31u + (unsigned)r) * 2654435761u;
    h ^= h >> 15;
    unsigned long long word = (unsigned long long)(h * 2246822519u) << 32 | i;
    int pixel = (int)(h % (unsigned)pixels);
    if (racy_load(&words[pixel]) < word) atomicMax(&words[pixel], word);
  }
}
KERNEL(selftest_visibility)
