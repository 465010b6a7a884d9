// Tensor-core tiles from raw registers, and scalar arithmetic.
#include "compat.cuh"

template <int A, int B, class F>
static __device__ __forceinline__ void tile(Buffer<const uint32_t> a, Buffer<const uint32_t> b, Buffer<const float> c,
                                            Buffer<float> d, F multiply) {
  int lane = (int)threadIdx.x, at = (int)blockIdx.x * 32 + lane;
  uint32_t ra[A], rb[B];
  float rc[4], rd[4];
  for (int i = 0; i < A; i++) ra[i] = a[at * A + i];
  for (int i = 0; i < B; i++) rb[i] = b[at * B + i];
  for (int i = 0; i < 4; i++) rc[i] = c[at * 4 + i];
  multiply(rd, ra, rb, rc);
  for (int i = 0; i < 4; i++) d[at * 4 + i] = rd[i];
}
#define TILE(name, A, B)                                                                                             \
  extern "C" __global__ void selftest_##name(Buffer<const uint32_t> a, Buffer<const uint32_t> b, Buffer<const float> c, \
                                             Buffer<float> d) {                                                      \
    tile<A, B>(a, b, c, d, [](float(&rd)[4], const uint32_t(&ra)[A], const uint32_t(&rb)[B], const float(&rc)[4]) {  \
      name(rd, ra, rb, rc);                                                                                          \
    });                                                                                                              \
  }                                                                                                                  \
  KERNEL(selftest_##name)
TILE(mma_m16n8k8_f16, 2, 1)
TILE(mma_m16n8k16_f16, 4, 2)
TILE(mma_m16n8k8_tf32, 4, 2)

// A sparse product: two registers of A and of B a lane, and its metadata.
extern "C" __global__ void selftest_mma_sp(Buffer<const uint32_t> a, Buffer<const uint32_t> b, Buffer<const uint32_t> metadata,
                                           Buffer<float> out) {
  const uint32_t rows[2] = {a[threadIdx.x * 2], a[threadIdx.x * 2 + 1]};
  const uint32_t columns[2] = {b[threadIdx.x * 2], b[threadIdx.x * 2 + 1]};
  const float c[4] = {1, 2, 3, 4};
  float d[4];
  mma_sp_m16n8k16_f16(d, rows, columns, c, metadata[threadIdx.x]);
  for (int k = 0; k < 4; k++) out[threadIdx.x * 4 + k] = d[k];
}
KERNEL(selftest_mma_sp)

// 16 words of output for each triple of floats.
extern "C" __global__ void selftest_numbers(Buffer<const float> in, Buffer<unsigned> out, int n) {
  int i = (int)(blockIdx.x * blockDim.x + threadIdx.x);
  if (i >= n) return;
  float a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];
  Buffer<unsigned> o = out + 16 * i;
  __half ha = __float2half_rn(a), hb = __float2half_rn(b), hc = __float2half_rn(c);
  o[0] = __half_as_ushort(ha);
  o[1] = __float_as_uint(__half2float(ha));
  o[2] = __half_as_ushort(__float2half_rz(a));
  o[3] = __half_as_ushort(__hadd(ha, hb));
  o[4] = __half_as_ushort(__hmul(ha, hb));
  o[5] = __half_as_ushort(__hfma(ha, hb, hc));
  o[6] = to_tf32(a);
  o[7] = __float_as_uint(__fmaf_rn(a, b, c));
  o[8] = __float_as_uint(a * b + c);
  o[9] = (unsigned)__float2int_rn(a);
  o[10] = (unsigned)__float2int_rd(a);
  o[11] = (unsigned)__float2int_rz(a);
  o[12] = __float2uint_rz(a);
  o[13] = __brev(__float_as_uint(a));
  o[14] = __umulhi(__float_as_uint(a), __float_as_uint(b));
  o[15] = pack_half2(a, b);
}
KERNEL(selftest_numbers)

// For speed figures: a thread's cost without and with collectives.
extern "C" __global__ void selftest_threads(Buffer<unsigned> out) { out[blockIdx.x * blockDim.x + threadIdx.x] = threadIdx.x; }
KERNEL(selftest_threads)
extern "C" __global__ void selftest_shuffles(Buffer<unsigned> out, int rounds) {
  unsigned v = threadIdx.x;
  for (int i = 0; i < rounds; i++) v = __shfl_xor_sync(~0u, v, 1);
  out[blockIdx.x * blockDim.x + threadIdx.x] = v;
}
KERNEL(selftest_shuffles)
