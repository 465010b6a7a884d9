// How many entries a list has. Nobody waits until the host knows: it makes room for as many as it expects, kernels count what
// there really is, and where that is more, there is nothing, and the frame is drawn again. Twin of src/cuda/count.rs.
#pragma once
#include "compat.cuh"

struct Count {
    Buffer<const uint64_t> counted;
    uint32_t room;
    // There are as many as there is room for.
    uint32_t known;

    __device__ __forceinline__ uint64_t all() const { return known ? room : counted[0]; }
    __device__ __forceinline__ bool fits() const { return all() <= room; }
    __device__ __forceinline__ uint32_t get() const {
        const uint64_t n = all();
        return n <= room ? uint32_t(n) : 0;
    }
};

namespace counts {

// More than there is ever room for.
constexpr uint64_t TOO_MANY = ~0ull;

// For atomics.
static __device__ __forceinline__ unsigned long long *word(uint64_t &counter) {
    return reinterpret_cast<unsigned long long *>(&counter);
}

// One more; what it was before.
static __device__ __forceinline__ uint64_t next(uint64_t &counter) { return atomicAdd(word(counter), 1ull); }

} // namespace counts
