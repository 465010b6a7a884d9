// Barriers and shared memory. scripts/sanitize_kernels.sh builds this with SELFTEST_NO_BARRIER to see it found.
#include "compat.cuh"

// sums[b]: of the block's 256 inputs; votes[b]: what the voting barriers said.
extern "C" __global__ void selftest_block(Buffer<const int> in, Buffer<int> sums, Buffer<int> votes) {
  SHARED(int, part, [256]);
  unsigned t = threadIdx.x, b = blockIdx.x;
  part[t] = in[b * 256 + t];
#ifndef SELFTEST_NO_BARRIER
  __syncthreads();
#endif
  for (unsigned d = 128; d; d >>= 1) {
    if (t < d) part[t] += part[t + d];
    __syncthreads();
  }
  int count = __syncthreads_count(t % 3 == 0);
  int all = __syncthreads_and(t < 256), not_all = __syncthreads_and(t < 255);
  int any = __syncthreads_or(t == 77), none = __syncthreads_or(t == 256);
  if (t == 0) {
    sums[b] = part[0];
    votes[b] = count | (all != 0) << 16 | (not_all != 0) << 17 | (any != 0) << 18 | (none != 0) << 19;
  }
}
KERNEL(selftest_block)

// Writes the block's numbers backwards, through memory whose size the launch chooses.
extern "C" __global__ void selftest_dynamic(Buffer<int> out, int n) {
  DYNAMIC_SHARED(int, s);
  int t = (int)threadIdx.x;
  s[n - 1 - t] = t;
  __syncthreads();
  out[(int)blockIdx.x * n + t] = s[t];
}
KERNEL(selftest_dynamic)

struct Cell {
  float2 at;
  int key;
};
static __device__ int row_sum(Span<const int> row) {
  int sum = 0;
  for (int i = 0; i < 4; i++) sum += row[i];
  return sum;
}
// Two dimensions, a structure, a scalar, a part handed to a function. Half of the threads leave before the last barrier.
extern "C" __global__ void selftest_shapes(Buffer<int> out) {
  SHARED(int, table, [8][4]);
  SHARED(Cell, cell, [2]);
  SHARED(int, total);
  int t = (int)threadIdx.x;
  if (t == 0) total = 0;
  table[t / 4][t % 4] = t;
  if (t < 2) cell[t] = {make_float2(1.0f, (float)t), 10 * t};
  __syncthreads();
  if (t < 8) atomicAdd(&total, row_sum(table[t]));
  if (t >= 16) return;
  __syncthreads();
  out[t] = total + cell[t & 1].key + (int)cell[1].at.y;
}
KERNEL(selftest_shapes)

// What a block finds in shared memory that it has not written: `left` is what the block before it left there.
extern "C" __global__ void selftest_poison(Buffer<unsigned> out) {
  SHARED(unsigned, left, [32]);
  DYNAMIC_SHARED(unsigned, dynamic);
  unsigned t = threadIdx.x, i = blockIdx.x * 32 + t;
  out[2 * i] = left[t];
  out[2 * i + 1] = dynamic[t];
  left[t] = dynamic[t] = 7;
}
KERNEL(selftest_poison)

// Lane order shows: which thread of the block, and which block, was the first to come.
extern "C" __global__ void selftest_order(Buffer<unsigned> ticket, Buffer<unsigned> out) {
  unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  out[2 * i] = atomicAdd(&ticket[0], 1u);
  __syncwarp();
  out[2 * i + 1] = atomicAdd(&ticket[0], 1u);
}
KERNEL(selftest_order)

// Waits for a flag that the block's last thread sets.
extern "C" __global__ void selftest_spin(Buffer<unsigned> out) {
  SHARED(unsigned, flag);
  if (threadIdx.x == 0) flag = 0;
  __syncthreads();
  if (threadIdx.x == blockDim.x - 1) atomicExch(&flag, 5u);
  while (atomicAdd(&flag, 0u) != 5u) __nanosleep(20);
  out[threadIdx.x] = racy_load(&flag);
}
KERNEL(selftest_spin)
