// What storing and arithmetic alone take: the floors that `bench evaluate` measures beside the kernels of evaluate. No frame
// runs these.
#include "tensor.cuh"

namespace floors {

constexpr uint32_t THREADS = 256;
// Sums a thread or warp has under way, so that no operation waits for the one before.
constexpr int CHAINS = 8;

} // namespace floors

// Stores `count` vectors of 16 bytes, and reads nothing.
extern "C" __global__ void __launch_bounds__(floors::THREADS) floor_store(Buffer<float4> out, uint64_t count) {
    const uint64_t all = uint64_t(gridDim.x) * floors::THREADS;
    for (uint64_t k = uint64_t(blockIdx.x) * floors::THREADS + threadIdx.x; k < count; k += all) {
        out[int64_t(k)] = make_float4(1.0f, 2.0f, 3.0f, 4.0f);
    }
}
KERNEL(floor_store)

// CHAINS * rounds multiply-adds a thread. The result is stored where it is NaN, which it never is: compilers don't know.
extern "C" __global__ void __launch_bounds__(floors::THREADS)
    floor_multiply_add(Buffer<float> out, uint32_t rounds, float factor) {
    float sums[floors::CHAINS];
#pragma unroll
    for (int k = 0; k < floors::CHAINS; k++) {
        sums[k] = float(threadIdx.x + k);
    }
    for (uint32_t r = 0; r < rounds; r++) {
#pragma unroll
        for (int k = 0; k < floors::CHAINS; k++) {
            sums[k] = __fmaf_rn(sums[k], factor, 1.0f);
        }
    }
    float total = 0.0f;
#pragma unroll
    for (int k = 0; k < floors::CHAINS; k++) {
        total += sums[k];
    }
    if (total != total) {
        out[0] = total;
    }
}
KERNEL(floor_multiply_add)

namespace floors {

// CHAINS * rounds products of tensor cores a warp.
template <class Format>
static __device__ __forceinline__ void multiply(Buffer<float> out, uint32_t rounds, float factor) {
    const typename Format::Pair a = Format::round(make_float2(factor, factor));
    float sums[CHAINS][4] = {};
    for (uint32_t r = 0; r < rounds; r++) {
#pragma unroll
        for (int k = 0; k < CHAINS; k++) {
            float d[4];
            Format::multiply(d, a, a, a, sums[k]);
#pragma unroll
            for (int i = 0; i < 4; i++) {
                sums[k][i] = d[i];
            }
        }
    }
    float total = 0.0f;
#pragma unroll
    for (int k = 0; k < CHAINS; k++) {
        total += sums[k][0] + sums[k][1] + sums[k][2] + sums[k][3];
    }
    if (total != total) {
        out[0] = total;
    }
}

} // namespace floors

#define FLOOR_PRODUCTS(name, Format)                                                                                   \
    extern "C" __global__ void __launch_bounds__(floors::THREADS)                                                      \
        name(Buffer<float> out, uint32_t rounds, float factor) {                                                       \
        floors::multiply<Format>(out, rounds, factor);                                                                 \
    }                                                                                                                  \
    KERNEL(name)

FLOOR_PRODUCTS(floor_products_f16, tensor::F16)
FLOOR_PRODUCTS(floor_products_f16_sparse, tensor::F16Sparse)
FLOOR_PRODUCTS(floor_products_tf32, tensor::Tf32)
