// The running block: its threads, warps, open collectives, and who may run next.
#pragma once
#include "cuda.h"
// The runtime's own code says `current` and `grid`.
#undef threadIdx
#undef blockIdx
#undef blockDim
#undef gridDim

#include "api.h"
#include "fiber.h"

namespace hp {

constexpr unsigned MAX_THREADS = 1024, MAX_WARPS = 32;
constexpr unsigned MAX_STATIC_SHARED = 48 << 10, MAX_SHARED = 227 << 10;  // of a block, sm_90
constexpr unsigned MAX_SHARED_VARIABLES = 256;

enum class LaneOrder : uint8_t { forward, reverse, random };
// first_ahead: the lowest warp runs until it must wait for the block; last_ahead: the highest; turns: all in lockstep.
enum class WarpOrder : uint8_t { first_ahead, last_ahead, turns, random };
enum class BlockOrder : uint8_t { forward, reverse, random };

struct Block;
struct Warp;

struct Fiber : Thread {
  Block *block;
  Warp *warp;
  Stack *stack;            // none before it starts and after it returns
  uint64_t value, result;  // what it brings to a collective and takes away
  unsigned extra;
  Op op;  // of the collective it was in last, and where that was
  Site at;
};

// A collective that some lanes of `mask` have reached.
struct Group {
  unsigned mask, arrived;
  Op op;
  Site at;
  char *order;  // what the race detector ties __syncwarp to
};

struct Warp {
  Fiber *lanes;
  unsigned exists, returned, ready;
  unsigned open_count;
  Group open[32];
};

struct Barrier {
  unsigned arrived;
  int sum;
  Op op;
  Site at;
  char order[2];
  unsigned phase;
};

struct Run {
  const Kernel *kernel;
  hp_launch launch;
  const void *const *arguments;
  const Range *ranges;
  size_t range_count;
  uint64_t blocks, stride, start;  // block n is (n * stride + start) mod blocks
  uint64_t next_block;             // atomic
  int stopped;                     // atomic
  int fault_lock;                  // atomic
  uint64_t fault_block;
  hp_fault fault;
  char begin, end;                 // what the race detector ties the start and the end of the launch to
};

// What one operating system thread needs to run blocks; kept between launches.
struct Block {
  Run *run;
  uint64_t number;
  unsigned threads, warps, left;  // left: threads that have not returned
  unsigned ready_warps, warp_now;
  unsigned yields;
  uint32_t random;
  bool failed;
  hp_fault fault;
  Barrier barrier;
  Fiber *fiber;  // MAX_THREADS
  Warp warp[MAX_WARPS];
  // Stacks are given to threads when they start, and passed on when they return.
  Stack *stacks;
  char *stack_memory;
  unsigned stack_count, free_count;
  Stack **free_stacks;
  Stack own;         // the operating system's
  const void *home;  // which of its threads ran the stacks last
  // Dynamic shared memory, then the static variables met so far. offset 0 is "not met".
  char *shared;
  unsigned shared_end, static_bytes;
  unsigned offset[MAX_SHARED_VARIABLES];
  unsigned order_count;
  char order[4096];  // addresses for Group::order
  char begin;        // what the race detector ties the start of a block to; blocks are not ordered
  char over[2];      // and the ends of the last block and this one, which used the same stacks and shared memory
  unsigned turn;     // which of the two is this one's
  Block *next;       // in the pool
};

inline Fiber *self() { return static_cast<Fiber *>(current); }
template <class F> inline void each(unsigned mask, F f) {
  for (; mask; mask &= mask - 1) f(__builtin_ctz(mask));
}
inline uint32_t draw(Block *b) {
  b->random ^= b->random << 13;
  b->random ^= b->random >> 17;
  return b->random ^= b->random << 5;
}

// schedule.cpp
const char *prepare_block(Block *b, Run *run);  // a message if memory can't be had
void run_block(Block *b);
void wait();                      // give up the processor until woken
[[noreturn]] void leave_block();  // after a fault
void wake(Warp *w, unsigned lanes);
// rendezvous.cpp
void thread_returned(Fiber *f);  // those who waited for it need not any more
// collectives.cpp
const char *name_of(Op op);
void evaluate(Warp *w, const Group &g);
// shared.cpp
bool map_shared(Block *b);
void start_shared(Block *b);  // everything poisoned, no variable met
// faults.cpp
void report_deadlock(Block *b);
// mma.cpp
void evaluate_mma(Warp *w, const Group &g);

}  // namespace hp
