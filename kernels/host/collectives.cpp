// What lanes get from a collective, computed once all have brought their values.
#include "block.h"

namespace hp {

const char *name_of(Op op) {
  static const char *const names[] = {
      "__syncwarp", "__shfl_sync", "__shfl_up_sync", "__shfl_down_sync", "__shfl_xor_sync", "__ballot_sync",
      "__any_sync", "__all_sync", "__match_any_sync", "__match_all_sync", "__reduce_add_sync", "__reduce_and_sync",
      "__reduce_or_sync", "__reduce_xor_sync", "__reduce_min_sync", "__reduce_max_sync", "__reduce_min_sync",
      "__reduce_max_sync", "mma.sync", "__syncthreads", "__syncthreads_count", "__syncthreads_and", "__syncthreads_or"};
  return names[(int)op];
}

static const char *absence(const Warp *w, unsigned lane) {
  if (lane > 31 || !(w->exists >> lane & 1)) return "which does not exist";
  return w->returned >> lane & 1 ? "which has returned" : "which takes no part";
}

static void shuffle_lanes(Warp *w, const Group &g) {
  each(g.arrived, [&](int lane) {
    unsigned source = w->lanes[lane].extra;
    if (source > 31 || !(g.arrived >> source & 1)) [[unlikely]]
      fail(FaultKind::source_lane, g.at, "%s: lane %d reads lane %d, %s", name_of(g.op), lane, (int)source,
           absence(w, source));
    w->lanes[lane].result = w->lanes[source].value;
  });
}

static void match_lanes(Warp *w, const Group &g) {
  each(g.arrived, [&](int lane) {
    unsigned same = 0;
    each(g.arrived, [&](int other) { same |= (unsigned)(w->lanes[other].value == w->lanes[lane].value) << other; });
    w->lanes[lane].result = g.op == Op::match_all && same != g.arrived ? 0 : same;
  });
}

static uint32_t reduce(const Warp *w, const Group &g) {
  uint32_t sum = 0, ballot = 0, all_bits = ~0u, any_bit = 0, parity = 0, low = ~0u, high = 0;
  int32_t low_signed = 2147483647, high_signed = -2147483647 - 1;
  each(g.arrived, [&](int lane) {
    uint32_t v = (uint32_t)w->lanes[lane].value;
    sum += v;
    ballot |= (uint32_t)(v != 0) << lane;
    all_bits &= v;
    any_bit |= v;
    parity ^= v;
    low = v < low ? v : low;
    high = v > high ? v : high;
    low_signed = (int32_t)v < low_signed ? (int32_t)v : low_signed;
    high_signed = (int32_t)v > high_signed ? (int32_t)v : high_signed;
  });
  switch (g.op) {
    case Op::ballot: return ballot;
    case Op::any: return ballot != 0;
    case Op::all: return ballot == g.arrived;
    case Op::add: return sum;
    case Op::bit_and: return all_bits;
    case Op::bit_or: return any_bit;
    case Op::bit_xor: return parity;
    case Op::min_unsigned: return low;
    case Op::max_unsigned: return high;
    case Op::min_signed: return (uint32_t)low_signed;
    case Op::max_signed: return (uint32_t)high_signed;
    default: return 0;
  }
}

void evaluate(Warp *w, const Group &g) {
  switch (g.op) {
    case Op::syncwarp: return;
    case Op::shuffle:
    case Op::shuffle_up:
    case Op::shuffle_down:
    case Op::shuffle_xor: return shuffle_lanes(w, g);
    case Op::match_any:
    case Op::match_all: return match_lanes(w, g);
    case Op::mma: return evaluate_mma(w, g);
    default: break;
  }
  uint32_t result = reduce(w, g);
  each(g.arrived, [&](int lane) { w->lanes[lane].result = result; });
}

}  // namespace hp
