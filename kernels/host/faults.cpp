// What went wrong, in words, with the place in the kernel.
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "block.h"

namespace hp {

static void place(hp_fault *fault, FaultKind kind, const Site &at, const Thread &thread) {
  fault->kind = (int)kind;
  const uint3 &b = grid.block_index, &t = thread.index;
  const uint32_t block[3] = {b.x, b.y, b.z}, index[3] = {t.x, t.y, t.z};
  memcpy(fault->block, block, sizeof block);
  memcpy(fault->thread, index, sizeof index);
  fault->line = at.line();
  fault->column = at.column();
  snprintf(fault->file, sizeof fault->file, "%s", at.file_name());
}

void fail(FaultKind kind, Site at, const char *format, ...) {
  Block *b = self()->block;
  place(&b->fault, kind, at, *self());
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(b->fault.message, sizeof b->fault.message, format, arguments);
  va_end(arguments);
  b->failed = true;
  leave_block();
}

void fail_buffer(uint64_t address, uint64_t alignment, uint32_t allocation, size_t size, Site at) {
  if (allocation >= grid.range_count || !grid.ranges[allocation].bytes)
    fail(FaultKind::out_of_bounds, at, "a pointer into allocation %u, which is gone or never was", allocation);
  const Range &range = grid.ranges[allocation];
  int64_t offset = (int64_t)(address - range.first);
  if (address % alignment)
    fail(FaultKind::misaligned, at, "byte %lld of allocation %u is not aligned to %llu bytes", (long long)offset, allocation,
         (unsigned long long)alignment);
  fail(FaultKind::out_of_bounds, at, "element %lld of allocation %u, which has %llu elements of %zu bytes",
       (long long)(offset < 0 ? (offset - (int64_t)size + 1) / (int64_t)size : offset / (int64_t)size), allocation,
       (unsigned long long)(range.bytes / size), size);
}

void fail_span(int64_t index, int64_t count, size_t size, Site at) {
  fail(FaultKind::out_of_bounds, at, "element %lld of shared memory that has %lld elements of %zu bytes", (long long)index,
       (long long)count, size);
}

// ---- deadlocks

struct Text {
  char *at;
  size_t room;
  __attribute__((format(printf, 2, 3))) void add(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(at, room, format, arguments);
    va_end(arguments);
    size_t used = (size_t)n < room ? (size_t)n : room - 1;
    at += used;
    room -= used;
  }
};

// Where the lanes are that a collective waits for; true if one waits with another mask.
static bool add_missing(Text *text, const Block *b, const Warp *w, const Group &g) {
  unsigned missing = g.mask & w->exists & ~w->returned & ~g.arrived;
  for (unsigned i = 0; i < w->open_count; i++)
    if (unsigned there = missing & w->open[i].arrived) {
      const Group &other = w->open[i];
      text->add("; lanes %08x of them wait at %s (%s:%u) with mask %08x: the masks disagree", there, name_of(other.op),
                other.at.file_name(), other.at.line(), other.mask);
      return true;
    }
  if (b->barrier.arrived) {
    const Fiber &f = w->lanes[__builtin_ctz(missing)];
    text->add("; lane %u waits at %s (%s:%u)", f.lane, name_of(f.op), f.at.file_name(), f.at.line());
  }
  return false;
}

void report_deadlock(Block *b) {
  const Barrier &bar = b->barrier;
  Text text{b->fault.message, sizeof b->fault.message};
  unsigned i = 0;
  while (b->warp[i].exists == b->warp[i].returned) i++;
  Fiber *first = &b->warp[i].lanes[__builtin_ctz(b->warp[i].exists & ~b->warp[i].returned)];
  place(&b->fault, FaultKind::deadlock, first->at, *first);
  text.add("deadlock: %u threads wait and none can run", b->left);
  if (bar.arrived)
    text.add("; %u of them wait at %s (%s:%u)", bar.arrived, name_of(bar.op), bar.at.file_name(), bar.at.line());
  for (unsigned wi = 0, told = 0; wi < b->warps && told < 2; wi++) {
    const Warp *w = &b->warp[wi];
    for (unsigned k = 0; k < w->open_count && told < 2; k++, told++) {
      const Group &g = w->open[k];
      text.add("; warp %u: lanes %08x wait at %s (%s:%u) for lanes %08x", wi, g.arrived, name_of(g.op), g.at.file_name(),
               g.at.line(), g.mask & w->exists & ~w->returned & ~g.arrived);
      if (add_missing(&text, b, w, g)) told = 2;
    }
  }
  b->failed = true;
}

}  // namespace hp
