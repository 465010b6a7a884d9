// Collectives of a warp and barriers of a block: who has arrived, who is missing, who should not be there.
#include <string.h>

#include "block.h"

namespace hp {

static bool same_site(const Site &a, const Site &b) {
  if (!memcmp(&a, &b, sizeof a)) [[likely]] return true;
  return a.line() == b.line() && a.column() == b.column() &&
         (a.file_name() == b.file_name() || !strcmp(a.file_name(), b.file_name()));
}

// The last lane is here: computes the results and wakes all.
static void complete(Warp *w, Group *g) {
  Group done = *g;
  *g = w->open[--w->open_count];
  evaluate(w, done);
  wake(w, done.arrived);
}
static bool is_full(const Warp *w, const Group *g) { return !(g->mask & w->exists & ~w->returned & ~g->arrived); }

static Group *join(Warp *w, Fiber *f, unsigned mask) {
  for (unsigned i = 0; i < w->open_count; i++)
    if (w->open[i].mask == mask) return &w->open[i];
  Block *b = f->block;
  Group *g = &w->open[w->open_count++];
  *g = {mask, 0, f->op, f->at, &b->order[b->order_count++ % sizeof b->order]};
  return g;
}

uint64_t collective(Op op, unsigned mask, uint64_t value, unsigned extra, Site at) {
  Fiber *f = self();
  Warp *w = f->warp;
  unsigned bit = 1u << f->lane;
  f->value = value;
  f->extra = extra;
  f->op = op;
  f->at = at;
  if (!(mask & bit)) [[unlikely]]
    fail(FaultKind::not_in_mask, at, "lane %u calls %s with mask %08x, which does not name it", f->lane, name_of(op), mask);
  Group *g = join(w, f, mask);
  if (g->op != op || !same_site(g->at, at)) [[unlikely]]
    fail(FaultKind::mismatch, at,
         "lanes of one warp are at different collectives: lane %u at %s, those of mask %08x at %s (%s:%u)", f->lane,
         name_of(op), g->arrived, name_of(g->op), g->at.file_name(), g->at.line());
  g->arrived |= bit;
  // Of all collectives only __syncwarp orders memory.
  char *order = RACE_DETECTION && op == Op::syncwarp ? g->order : nullptr;
  if (order) race_release(order);
  if (is_full(w, g)) complete(w, g);
  wait();
  if (order) race_acquire(order);
  return f->result;
}

static void release(Block *b) {
  Barrier *bar = &b->barrier;
  int result = bar->op == Op::syncthreads_count  ? bar->sum
               : bar->op == Op::syncthreads_and ? bar->sum == (int)bar->arrived
                                                : bar->sum != 0;
  bar->arrived = 0;
  bar->sum = 0;
  bar->phase ^= 1;
  for (unsigned i = 0; i < b->warps; i++) {
    Warp *w = &b->warp[i];
    unsigned lanes = w->exists & ~w->returned;
    each(lanes, [&](int lane) { w->lanes[lane].result = (uint64_t)result; });
    if (lanes) wake(w, lanes);
  }
}

int barrier(Op op, int predicate, Site at) {
  Fiber *f = self();
  Block *b = f->block;
  Barrier *bar = &b->barrier;
  f->op = op;
  f->at = at;
  if (!bar->arrived) {
    bar->op = op;
    bar->at = at;
  } else if (bar->op != op || !same_site(bar->at, at)) [[unlikely]] {
    fail(FaultKind::mismatch, at, "threads of one block are at different barriers: one at %s, %u others at %s (%s:%u)",
         name_of(op), bar->arrived, name_of(bar->op), bar->at.file_name(), bar->at.line());
  }
  bar->sum += predicate != 0;
  char *order = &bar->order[bar->phase];
  race_release(order);
  if (++bar->arrived == b->left) release(b);
  wait();
  race_acquire(order);
  return (int)f->result;
}

void thread_returned(Fiber *f) {
  Warp *w = f->warp;
  Block *b = f->block;
  b->left--;
  w->returned |= 1u << f->lane;
  for (unsigned i = 0; i < w->open_count;)
    if (is_full(w, &w->open[i])) complete(w, &w->open[i]);
    else i++;
  if (b->left && b->barrier.arrived == b->left) release(b);
}

// A fence before an atomic and one after the atomic that read it order memory. The race detector can't see which atomics
// belong together: it takes every fence as ordered after all earlier ones, so it misses some races and invents none.
void fence() {
  static char fences;
  __atomic_thread_fence(__ATOMIC_SEQ_CST);
  race_release(&fences);
  race_acquire(&fences);
}

}  // namespace hp
