// Every warp collective; tests/kernels/collectives.rs computes the same plainly.
#include "compat.cuh"

constexpr int WORDS = 32;  // of output a thread

extern "C" __global__ void selftest_warp(Buffer<const unsigned> in, Buffer<unsigned> out) {
  unsigned i = blockIdx.x * blockDim.x + threadIdx.x, lane = threadIdx.x & 31, v = in[i];
  Buffer<unsigned> o = out + i * WORDS;
  o[0] = __shfl_sync(~0u, v, 5);
  o[1] = __shfl_sync(~0u, v, lane + 3, 8);
  o[2] = __shfl_up_sync(~0u, v, 3);
  o[3] = __shfl_up_sync(~0u, v, 2, 4);
  o[4] = __shfl_down_sync(~0u, v, 4);
  o[5] = __shfl_down_sync(~0u, v, 1, 16);
  o[6] = __shfl_xor_sync(~0u, v, 17);
  o[7] = __shfl_xor_sync(~0u, v, 4, 8);
  o[8] = __ballot_sync(~0u, v & 1);
  o[9] = (unsigned)__any_sync(~0u, v > 4000000000u) | (unsigned)__any_sync(~0u, lane == 9) << 1;
  o[10] = (unsigned)__all_sync(~0u, lane < 31) | (unsigned)__all_sync(~0u, lane < 32) << 1;
  o[11] = __match_any_sync(~0u, v % 5);
  int same;
  unsigned matching = __match_all_sync(~0u, v * 0 + 7, &same);
  o[12] = matching ^ (unsigned)same;
  matching = __match_all_sync(~0u, lane, &same);
  o[13] = matching ^ (unsigned)same;
  o[14] = __reduce_add_sync(~0u, v);
  o[15] = __reduce_min_sync(~0u, v);
  o[16] = __reduce_max_sync(~0u, v);
  o[17] = (unsigned)__reduce_min_sync(~0u, (int)v);
  o[18] = (unsigned)__reduce_max_sync(~0u, (int)v);
  o[19] = __reduce_and_sync(~0u, v);
  o[20] = __reduce_or_sync(~0u, v);
  o[21] = __reduce_xor_sync(~0u, v);
  unsigned long long wide = __shfl_xor_sync(~0u, (unsigned long long)v << 20, 1);
  o[22] = (unsigned)(wide >> 20);
  o[23] = __float_as_uint(__shfl_sync(~0u, (float)lane + 0.5f, 30 - (int)lane / 2));
  // Two halves of a warp on different paths, and a lane alone.
  if (lane < 16) o[24] = __reduce_or_sync(0xffffu, 1u << lane);
  else o[24] = __shfl_sync(0xffff0000u, lane, 20);
  o[25] = __ballot_sync(1u << lane, 1);
  o[26] = (unsigned)__half2float(__shfl_sync(~0u, __float2half_rn((float)lane), 11));
  if (lane & 1) return;  // lanes that have returned do not hold the others back
  __syncwarp(0x55555555u);
  o[27] = __ballot_sync(0x55555555u, 1);
  o[28] = __ballot_sync(~0u, lane != 4);
}
KERNEL(selftest_warp)
