// Kernels by name, launches, and the blocks of a launch on any number of operating system threads.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "block.h"

namespace hp {

static Kernel *kernels;  // filled before main
void add_kernel(Kernel *kernel) {
  kernel->next = kernels;
  kernels = kernel;
}

static void lock(int *flag) {
  while (__atomic_exchange_n(flag, 1, __ATOMIC_ACQUIRE)) {
  }
}
static void unlock(int *flag) { __atomic_store_n(flag, 0, __ATOMIC_RELEASE); }

// Blocks that no launch uses; their stacks are expensive to map anew.
static Block *idle;
static int idle_lock;
static Block *take_block() {
  lock(&idle_lock);
  Block *b = idle;
  if (b) idle = b->next;
  unlock(&idle_lock);
  return b ? b : static_cast<Block *>(calloc(1, sizeof(Block)));
}
static void give_back(Block *b) {
  lock(&idle_lock);
  b->next = idle;
  idle = b;
  unlock(&idle_lock);
}

// Among faults of several operating system threads the one of the first block counts.
static void keep_fault(Run *run, const hp_fault &fault, uint64_t block) {
  lock(&run->fault_lock);
  if (!run->fault.kind || block < run->fault_block) {
    run->fault = fault;
    run->fault_block = block;
  }
  unlock(&run->fault_lock);
  __atomic_store_n(&run->stopped, 1, __ATOMIC_RELAXED);
}

static void refuse(hp_fault *fault, const char *why) {
  *fault = {};
  fault->kind = (int)FaultKind::bad_launch;
  snprintf(fault->message, sizeof fault->message, "%s", why);
}
static const char *objection(const hp_launch &l) {
  uint64_t threads = (uint64_t)l.block[0] * l.block[1] * l.block[2];
  if (!threads || l.block[0] > 1024 || l.block[1] > 1024 || l.block[2] > 64 || threads > MAX_THREADS)
    return "a block must have 1 to 1024 threads, at most 64 along z";
  if (!l.grid[0] || !l.grid[1] || !l.grid[2] || l.grid[0] > 0x7fffffffu || l.grid[1] > 65535 || l.grid[2] > 65535)
    return "a grid must have 1 to 2^31 - 1 blocks along x, 1 to 65535 along y and z";
  if (l.dynamic_bytes > MAX_SHARED) return "a block can have at most 227 KiB of shared memory";
  return nullptr;
}

// Block n is (n stride + start) mod blocks: each one once, as the stride has no factor in common with their number.
static void order_blocks(Run *run) {
  uint64_t n = run->blocks;
  run->stride = 1;
  run->start = 0;
  if ((BlockOrder)run->launch.blocks == BlockOrder::reverse) run->stride = run->start = n - 1;
  if ((BlockOrder)run->launch.blocks != BlockOrder::random) return;
  uint64_t seed = (run->launch.seed + 1) * 0x9e3779b97f4a7c15ull;
  run->start = seed % n;
  for (run->stride = (seed >> 32) % n + 1;; run->stride++) {
    uint64_t a = run->stride, b = n;
    while (b) {
      uint64_t rest = a % b;
      a = b;
      b = rest;
    }
    if (a == 1) return;
  }
}

static void run_one(Block *b, uint64_t position) {
  Run *run = b->run;
  const uint32_t *size = run->launch.grid;
  uint64_t n = (uint64_t)(((unsigned __int128)position * run->stride + run->start) % run->blocks);
  uint64_t row = n / size[0];
  grid.block_index = {(unsigned)(n % size[0]), (unsigned)(row % size[1]), (unsigned)(row / size[1])};
  b->random = (run->launch.seed * 2654435761u + (uint32_t)n * 40503u) | 1;
  run_block(b);
  if (b->failed) keep_fault(run, b->fault, n);
}

}  // namespace hp

using namespace hp;

const Kernel *hp_next(const Kernel *kernel) { return kernel ? kernel->next : kernels; }
const char *hp_name(const Kernel *kernel) { return kernel->name; }
uint32_t hp_parameter_count(const Kernel *kernel) { return kernel->parameter_count; }
uint32_t hp_parameter_bytes(const Kernel *kernel, uint32_t index) { return kernel->parameters[index].bytes; }
bool hp_parameter_is_plain_pointer(const Kernel *kernel, uint32_t index) { return kernel->parameters[index].plain_pointer; }
const Kernel *hp_find(const char *name) {
  const Kernel *k = kernels;
  while (k && strcmp(k->name, name)) k = k->next;
  return k;
}

Run *hp_begin(const Kernel *kernel, const hp_launch *launch, const void *const *arguments, const Range *ranges,
              size_t range_count, hp_fault *fault) {
  const char *why = objection(*launch);
  Run *run = why ? nullptr : static_cast<Run *>(calloc(1, sizeof(Run)));
  if (!run) {
    refuse(fault, why ? why : "no memory for a launch");
    return nullptr;
  }
  run->kernel = kernel;
  run->launch = *launch;
  run->arguments = arguments;
  run->ranges = ranges;
  run->range_count = range_count;
  run->blocks = (uint64_t)launch->grid[0] * launch->grid[1] * launch->grid[2];
  order_blocks(run);
  race_release(&run->begin);
  return run;
}

// What this thread runs one block in, and the next one in another: what runs in the same one is ordered for the race detector.
constexpr unsigned PLACES = RACE_DETECTION ? 3 : 1;

static bool prepare(Block **place, Run *run) {
  if (*place) return true;
  *place = take_block();
  const char *why = *place ? prepare_block(*place, run) : "no memory for a block";
  if (!why) return true;
  hp_fault fault;
  refuse(&fault, why);
  keep_fault(run, fault, 0);
  return false;
}

void hp_work(Run *run) {
  race_acquire(&run->begin);
  Block *places[PLACES] = {};
  const uint32_t *g = run->launch.grid, *s = run->launch.block;
  grid = {};
  grid.block_size = {s[0], s[1], s[2]};
  grid.size = {g[0], g[1], g[2]};
  grid.ranges = run->ranges;
  grid.range_count = run->range_count;
  for (unsigned done = 0; !__atomic_load_n(&run->stopped, __ATOMIC_RELAXED); done++) {
    Block **place = &places[done % PLACES];
    if (!prepare(place, run)) break;
    uint64_t position = __atomic_fetch_add(&run->next_block, 1, __ATOMIC_RELAXED);
    if (position >= run->blocks) break;
    run_one(*place, position);
  }
  for (Block *b : places)
    if (b) give_back(b);
}

void hp_end(Run *run, hp_fault *fault) {
  race_acquire(&run->end);
  *fault = run->fault;
  free(run);
}
