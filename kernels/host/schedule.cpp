// Which thread of a block runs next, from the first one to the last.
#include <sched.h>
#include <stdlib.h>
#include <string.h>

#include "block.h"

namespace hp {

__thread Thread *current;
__thread Grid grid;

static unsigned any_bit(Block *b, unsigned mask) {
  for (unsigned skip = draw(b) % __builtin_popcount(mask); skip; skip--) mask &= mask - 1;
  return __builtin_ctz(mask);
}
static unsigned pick_warp(Block *b) {
  unsigned ready = b->ready_warps;
  switch ((WarpOrder)b->run->launch.warps) {
    case WarpOrder::first_ahead: return __builtin_ctz(ready);
    case WarpOrder::last_ahead: return 31 - __builtin_clz(ready);
    case WarpOrder::turns: {
      unsigned after = ready & ~((2u << b->warp_now) - 1);
      return __builtin_ctz(after ? after : ready);
    }
    case WarpOrder::random: break;
  }
  return any_bit(b, ready);
}
static unsigned pick_lane(Block *b, unsigned ready) {
  switch ((LaneOrder)b->run->launch.lanes) {
    case LaneOrder::forward: return __builtin_ctz(ready);
    case LaneOrder::reverse: return 31 - __builtin_clz(ready);
    case LaneOrder::random: break;
  }
  return any_bit(b, ready);
}
static Fiber *take(Block *b, unsigned warp, unsigned lane) {
  Warp *w = &b->warp[warp];
  b->warp_now = warp;
  w->ready &= ~(1u << lane);
  if (!w->ready) b->ready_warps &= ~(1u << warp);
  return &w->lanes[lane];
}
static Fiber *pick(Block *b) {
  if (!b->ready_warps || b->failed) return nullptr;
  unsigned warp = pick_warp(b);
  return take(b, warp, pick_lane(b, b->warp[warp].ready));
}
void wake(Warp *w, unsigned lanes) {
  Block *b = w->lanes[0].block;
  w->ready |= lanes;
  b->ready_warps |= 1u << (w - b->warp);
}

// Goes on with `next`, or with run_block where there is none.
static void go(Block *b, Stack *from, Fiber *next) {
  if (!next) return switch_stack(from, &b->own);
  if (!next->stack) next->stack = b->free_stacks[--b->free_count];
  current = next;
  switch_stack(from, next->stack);
}
void wait() {
  Fiber *me = self();
  Fiber *next = pick(me->block);
  if (next != me) go(me->block, me->stack, next);
}
void leave_block() {
  Fiber *me = self();
  switch_stack(me->stack, &me->block->own);
  __builtin_unreachable();
}

// A loop that waits for another thread must not be chosen again and again, so this ignores the orders.
void yield() {
  Fiber *me = self();
  Block *b = me->block;
  if (++b->yields > 1u << 26)
    fail(FaultKind::deadlock, me->at, "__nanosleep was called 2^26 times in one block: what it waits for does not come");
  if (!b->ready_warps) {
    sched_yield();
    return;
  }
  unsigned warp = any_bit(b, b->ready_warps);
  Fiber *next = take(b, warp, any_bit(b, b->warp[warp].ready));
  wake(me->warp, 1u << me->lane);
  go(b, me->stack, next);
}

// Runs threads one after another. A thread that never waits costs no switch: its successor starts on the same stack.
static void run_threads() {
  arrived();
  for (;;) {
    Fiber *f = self();
    Block *b = f->block;
    race_acquire(&b->begin);
    race_acquire(&b->over[b->turn ^ 1]);
    b->run->kernel->call(b->run->arguments);
    race_release(&b->over[b->turn]);
    race_release(&b->run->end);
    thread_returned(f);
    Stack *mine = f->stack;
    f->stack = nullptr;
    Fiber *next = pick(b);
    if (RACE_DETECTION) {
      go(b, mine, next);  // its next thread may race with this one
    } else if (next && !next->stack) {
      next->stack = mine;
      current = next;
    } else {
      b->free_stacks[b->free_count++] = mine;
      go(b, mine, next);
    }
  }
}

static void drop_stacks(Block *b) {
  if (RACE_DETECTION)
    for (unsigned i = 0; i < b->stack_count; i++) race_destroy(&b->stacks[i]);
  if (b->stack_memory) unmap_stacks(b->stack_memory, b->stack_count);
  b->stack_memory = nullptr;
  b->stack_count = 0;
}
static void put_stacks_back(Block *b) {
  b->free_count = b->stack_count;
  for (unsigned i = 0; i < b->stack_count; i++) b->free_stacks[b->stack_count - 1 - i] = &b->stacks[i];
}
static void reset_stacks(Block *b) {
  for (unsigned i = 0; i < b->stack_count; i++) reset_stack(&b->stacks[i], run_threads);
  put_stacks_back(b);
}
static bool have_stacks(Block *b, unsigned count) {
  if (count <= b->stack_count) return true;
  drop_stacks(b);
  b->stack_memory = map_stacks(b->stacks, count);
  if (!b->stack_memory) return false;
  b->stack_count = count;
  if (RACE_DETECTION)
    for (unsigned i = 0; i < count; i++) race_create(&b->stacks[i]);
  reset_stacks(b);
  return true;
}

static const char *allocate(Block *b) {
  if (!b->fiber) b->fiber = static_cast<Fiber *>(calloc(MAX_THREADS, sizeof(Fiber)));
  if (!b->stacks) b->stacks = static_cast<Stack *>(calloc(MAX_THREADS, sizeof(Stack)));
  if (!b->free_stacks) b->free_stacks = static_cast<Stack **>(calloc(MAX_THREADS, sizeof(Stack *)));
  if (!b->fiber || !b->stacks || !b->free_stacks || !map_shared(b)) return "no memory for a block";
  return have_stacks(b, b->threads) ? nullptr : "no memory for the stacks of a block's threads";
}
const char *prepare_block(Block *b, Run *run) {
  const uint32_t *size = run->launch.block;
  b->run = run;
  b->threads = size[0] * size[1] * size[2];
  b->warps = (b->threads + 31) / 32;
  if (const char *why = allocate(b)) return why;
  // Code that waits on a stack may have kept the address of a thread-local variable, which is another one here.
  if (b->home != &current) reset_stacks(b);
  b->home = &current;
  adopt_own_stack(&b->own);
  for (unsigned i = 0; i < b->threads; i++) {
    Fiber &f = b->fiber[i];
    f = {};
    f.index = {i % size[0], i / size[0] % size[1], i / (size[0] * size[1])};
    f.lane = i % 32;
    f.block = b;
    f.warp = &b->warp[i / 32];
  }
  return nullptr;
}

void run_block(Block *b) {
  b->left = b->threads;
  b->failed = false;
  b->yields = 0;
  b->warp_now = MAX_WARPS - 1;  // turns begin with warp 0
  b->barrier = {};
  for (unsigned i = 0; i < b->warps; i++) {
    unsigned lanes = b->threads - i * 32;
    Warp &w = b->warp[i];
    w.lanes = &b->fiber[i * 32];
    w.exists = lanes >= 32 ? ~0u : (1u << lanes) - 1;
    w.returned = w.open_count = 0;
    wake(&w, w.exists);
  }
  start_shared(b);
  b->turn ^= 1;
  race_release(&b->begin);
  go(b, &b->own, pick(b));
  if (!b->failed && b->left) report_deadlock(b);
  if (b->failed) {
    b->ready_warps = 0;
    for (unsigned i = 0; i < b->threads; i++) b->fiber[i].stack = nullptr;
    for (unsigned i = 0; i < b->warps; i++) b->warp[i].ready = 0;
    if (RACE_DETECTION) drop_stacks(b);  // who ran there never says that it is over
    have_stacks(b, b->threads);
    reset_stacks(b);
  } else if (RACE_DETECTION) {
    put_stacks_back(b);
  }
}

}  // namespace hp
