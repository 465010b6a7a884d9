// The one header that kernels include: CUDA under nvcc, the host shim elsewhere.
#pragma once
#ifdef __CUDACC__
#include <cstdint>
#define EXPORT_KERNEL(name)
#else
#include "cuda_host.h"
#endif
