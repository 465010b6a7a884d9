// What Rust (src/emulated/ffi.rs) and the sanitizer driver call. A run is one launch: hp_begin, hp_work on as many threads as
// wanted, hp_end. Nothing is shared between runs, so that they may overlap.
#pragma once
#include <stddef.h>
#include <stdint.h>

namespace hp {
struct Kernel;
struct Run;
struct Range;
}  // namespace hp

extern "C" {

struct hp_launch {
  uint32_t grid[3], block[3];
  uint32_t dynamic_bytes;
  uint32_t seed;
  // Who runs first among lanes of a warp, warps of a block, blocks of the grid: LaneOrder, WarpOrder, BlockOrder of block.h.
  uint8_t lanes, warps, blocks;
  uint8_t tensor_cores;  // 0: sm_80 to sm_89, 1: sm_90 and later
};

// The first thing that went wrong; `kind` is hp::FaultKind, 0 if nothing did.
struct hp_fault {
  int32_t kind;
  uint32_t block[3], thread[3];
  uint32_t line, column;
  char file[256];
  char message[1024];
};

const hp::Kernel *hp_find(const char *name);
const hp::Kernel *hp_next(const hp::Kernel *kernel);  // the first one after null
const char *hp_name(const hp::Kernel *kernel);
uint32_t hp_parameter_count(const hp::Kernel *kernel);
uint32_t hp_parameter_bytes(const hp::Kernel *kernel, uint32_t index);
bool hp_parameter_is_plain_pointer(const hp::Kernel *kernel, uint32_t index);

// Null if `fault` says why the launch is refused. Arguments and ranges must live until hp_end; range 0 is not used.
hp::Run *hp_begin(const hp::Kernel *kernel, const hp_launch *launch, const void *const *arguments, const hp::Range *ranges,
                  size_t range_count, hp_fault *fault);
void hp_work(hp::Run *run);
void hp_end(hp::Run *run, hp_fault *fault);
}
