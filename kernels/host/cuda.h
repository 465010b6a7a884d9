// CUDA C++ for a plain C++20 compiler: a kernel includes ../compat.cuh, which includes this. README.md in this folder says
// what is emulated and how.
#pragma once
#include "language.h"

#include "runtime.h"

#include "memory.h"

#include "atomics.h"
#include "collectives.h"
#include "half.h"
#include "intrinsics.h"
