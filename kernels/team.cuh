// The lanes that look at one patch together: a single thread, or a warp. What they find does not depend on how many they are.
#pragma once
#include "compat.cuh"

template <int LANES> struct Team {
    static_assert(LANES == 1 || LANES == 32);
    int lane;

    static __device__ __forceinline__ Team here() { return {LANES == 1 ? 0 : int(threadIdx.x % 32)}; }

    __device__ __forceinline__ void sync() const {
        if (LANES > 1) {
            __syncwarp();
        }
    }

    // Of all lanes' numbers; what is not a number does not count.
    __device__ __forceinline__ double least(double value) const {
        for (int step = LANES / 2; step > 0; step /= 2) {
            value = min(value, __shfl_xor_sync(~0u, value, step));
        }
        return value;
    }

    __device__ __forceinline__ double most(double value) const {
        for (int step = LANES / 2; step > 0; step /= 2) {
            value = max(value, __shfl_xor_sync(~0u, value, step));
        }
        return value;
    }

    __device__ __forceinline__ bool all(bool holds) const { return LANES == 1 ? holds : __all_sync(~0u, holds) != 0; }

    // The first lane's number.
    template <class T> __device__ __forceinline__ T first(T value) const {
        return LANES == 1 ? value : __shfl_sync(~0u, value, 0);
    }
};

// The least and the largest of some numbers.
struct Extremes {
    double low = INFINITY, high = -INFINITY;

    __device__ __forceinline__ void add(double value) {
        low = min(low, value);
        high = max(high, value);
    }

    template <int LANES> __device__ __forceinline__ Extremes of(const Team<LANES> &team) const {
        Extremes all;
        all.low = team.least(low);
        all.high = team.most(high);
        return all;
    }
};
