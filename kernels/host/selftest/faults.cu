// One mistake a kernel. tests/kernels/faults.rs looks the marks up here, to know the line that a diagnosis must name.
#include "compat.cuh"

extern "C" __global__ void fault_not_in_mask(Buffer<unsigned> out) {
  out[threadIdx.x] = __ballot_sync(0xffffu, 1);  // MARK not_in_mask
}
KERNEL(fault_not_in_mask)

extern "C" __global__ void fault_mismatch(Buffer<unsigned> out) {
  if (threadIdx.x < 16) out[0] = __ballot_sync(~0u, 1);  // MARK mismatch_others
  else out[1] = (unsigned)__any_sync(~0u, 0);            // MARK mismatch
}
KERNEL(fault_mismatch)

// The same operation twice in one line.
extern "C" __global__ void fault_one_line(Buffer<unsigned> out) {
  out[threadIdx.x] = threadIdx.x & 1 ? __ballot_sync(~0u, 1) : __ballot_sync(~0u, 0);  // MARK one_line
}
KERNEL(fault_one_line)

extern "C" __global__ void fault_masks_disagree(Buffer<unsigned> out) {
  out[threadIdx.x] = __ballot_sync(threadIdx.x < 16 ? ~0u : 0xfffffffeu, 1);  // MARK masks_disagree
}
KERNEL(fault_masks_disagree)

extern "C" __global__ void fault_deadlock(Buffer<unsigned> out) {
  if (threadIdx.x < 16) __syncwarp();  // MARK deadlock
  else __syncthreads();                // MARK deadlock_barrier
  out[threadIdx.x] = 1;
}
KERNEL(fault_deadlock)

extern "C" __global__ void fault_barriers(Buffer<unsigned> out) {
  if (threadIdx.x < 32) __syncthreads();  // MARK barriers_others
  else __syncthreads();                   // MARK barriers
  out[threadIdx.x] = 1;
}
KERNEL(fault_barriers)

extern "C" __global__ void fault_returned_lane(Buffer<unsigned> out) {
  if (threadIdx.x >= 30) return;
  out[threadIdx.x] = __shfl_down_sync(~0u, threadIdx.x, 1);  // MARK returned_lane
}
KERNEL(fault_returned_lane)

extern "C" __global__ void fault_source_lane(Buffer<unsigned> out) {
  if (threadIdx.x < 8) out[threadIdx.x] = __shfl_xor_sync(0xffu, threadIdx.x, 8);  // MARK source_lane
}
KERNEL(fault_source_lane)

extern "C" __global__ void fault_incomplete_warp(Buffer<float> out) {
  if (threadIdx.x == 31) return;
  uint32_t a[2] = {0, 0}, b[1] = {0};
  float c[4] = {0, 0, 0, 0}, d[4];
  mma_m16n8k8_f16(d, a, b, c);  // MARK incomplete_warp
  out[threadIdx.x] = d[0];
}
KERNEL(fault_incomplete_warp)

extern "C" __global__ void fault_buffer(Buffer<const float> in, Buffer<float> out, int offset) {
  out[threadIdx.x] = in[(int)threadIdx.x + offset];  // MARK buffer
}
KERNEL(fault_buffer)

extern "C" __global__ void fault_misaligned(Buffer<const float> in, Buffer<float> out) {
  Buffer<const float4> four = as<const float4>(in + 1);
  out[threadIdx.x] = four[0].x;  // MARK misaligned
}
KERNEL(fault_misaligned)

extern "C" __global__ void fault_atomic(Buffer<unsigned> out, unsigned i) {
  atomicAdd(&out[i], 1u);  // MARK atomic
}
KERNEL(fault_atomic)

extern "C" __global__ void fault_shared(Buffer<int> out, int i) {
  SHARED(int, s, [64]);
  s[threadIdx.x] = 1;
  __syncthreads();
  out[threadIdx.x] = s[i];  // MARK shared
}
KERNEL(fault_shared)

extern "C" __global__ void fault_shared_row(Buffer<int> out, int i) {
  SHARED(int, s, [4][8]);
  Span<int> row = s[3];
  row[i] = 1;  // MARK shared_row
  out[0] = s[3][7];
}
KERNEL(fault_shared_row)

extern "C" __global__ void fault_dynamic(Buffer<int> out, int i) {
  DYNAMIC_SHARED(int, s);
  s[i] = 1;  // MARK dynamic
  out[0] = s[0];
}
KERNEL(fault_dynamic)

extern "C" __global__ void fault_too_much_shared(Buffer<int> out) {
  SHARED(int, s, [9000]);
  SHARED(int, more, [4000]);  // MARK too_much_shared
  s[0] = more[0] = 1;
  out[0] = s[0];
}
KERNEL(fault_too_much_shared)
