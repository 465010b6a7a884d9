// Barriers, votes, shuffles, matches and reductions. `__activemask` is left out on purpose: CUDA does not define what a
// kernel could rely on. Only __syncwarp, __syncthreads and __threadfence order memory, as in CUDA; the race detector knows.
#pragma once
#include "half.h"
#include "runtime.h"

#define HP_AT hp::Site at = hp::Site::current()

inline void __syncthreads(HP_AT) { hp::barrier(hp::Op::syncthreads, 0, at); }
inline int __syncthreads_count(int p, HP_AT) { return hp::barrier(hp::Op::syncthreads_count, p, at); }
inline int __syncthreads_and(int p, HP_AT) { return hp::barrier(hp::Op::syncthreads_and, p, at); }
inline int __syncthreads_or(int p, HP_AT) { return hp::barrier(hp::Op::syncthreads_or, p, at); }
inline void __syncwarp(unsigned mask = ~0u, HP_AT) { hp::collective(hp::Op::syncwarp, mask, 0, 0, at); }
inline void __threadfence() { hp::fence(); }
inline void __threadfence_block() { hp::fence(); }
inline void __nanosleep(unsigned) { hp::yield(); }

inline unsigned __ballot_sync(unsigned mask, int p, HP_AT) {
  return (unsigned)hp::collective(hp::Op::ballot, mask, p != 0, 0, at);
}
inline int __any_sync(unsigned mask, int p, HP_AT) { return (int)hp::collective(hp::Op::any, mask, p != 0, 0, at); }
inline int __all_sync(unsigned mask, int p, HP_AT) { return (int)hp::collective(hp::Op::all, mask, p != 0, 0, at); }

#define HP_REDUCE_INT(NAME, UNSIGNED, SIGNED)                                                     \
  inline unsigned __reduce_##NAME##_sync(unsigned mask, unsigned v, HP_AT) {                      \
    return (unsigned)hp::collective(hp::Op::UNSIGNED, mask, v, 0, at);                            \
  }                                                                                               \
  inline int __reduce_##NAME##_sync(unsigned mask, int v, HP_AT) {                                \
    return (int)hp::collective(hp::Op::SIGNED, mask, (unsigned)v, 0, at);                         \
  }
HP_REDUCE_INT(add, add, add)
HP_REDUCE_INT(min, min_unsigned, min_signed)
HP_REDUCE_INT(max, max_unsigned, max_signed)
#undef HP_REDUCE_INT
inline unsigned __reduce_and_sync(unsigned mask, unsigned v, HP_AT) {
  return (unsigned)hp::collective(hp::Op::bit_and, mask, v, 0, at);
}
inline unsigned __reduce_or_sync(unsigned mask, unsigned v, HP_AT) {
  return (unsigned)hp::collective(hp::Op::bit_or, mask, v, 0, at);
}
inline unsigned __reduce_xor_sync(unsigned mask, unsigned v, HP_AT) {
  return (unsigned)hp::collective(hp::Op::bit_xor, mask, v, 0, at);
}

namespace hp {
// The types that CUDA shuffles and matches, as the 64 bits that lanes exchange.
template <class T> uint64_t to_bits(T v) {
  static_assert(std::is_arithmetic_v<T> || std::is_same_v<T, __half> || std::is_same_v<T, __half2>);
  uint64_t bits = 0;
  memcpy(&bits, &v, sizeof v);
  return bits;
}
template <class T> T from_bits(uint64_t bits) {
  T v;
  memcpy(&v, &bits, sizeof v);
  return v;
}
template <class T> T shuffle(Op op, unsigned mask, T v, int source, Site at) {
  return from_bits<T>(collective(op, mask, to_bits(v), (unsigned)source, at));
}
}  // namespace hp

template <class T> T __shfl_sync(unsigned mask, T v, int source, int width = 32, HP_AT) {
  int lane = (int)hp::current->lane;
  return hp::shuffle(hp::Op::shuffle, mask, v, (lane & ~(width - 1)) | (source & (width - 1)), at);
}
// A lane whose source lies outside its segment of `width` lanes keeps its own value.
template <class T> T __shfl_up_sync(unsigned mask, T v, unsigned delta, int width = 32, HP_AT) {
  int lane = (int)hp::current->lane, source = lane - (int)delta;
  return hp::shuffle(hp::Op::shuffle_up, mask, v, source < (lane & ~(width - 1)) ? lane : source, at);
}
template <class T> T __shfl_down_sync(unsigned mask, T v, unsigned delta, int width = 32, HP_AT) {
  int lane = (int)hp::current->lane, source = lane + (int)delta;
  return hp::shuffle(hp::Op::shuffle_down, mask, v, source > (lane | (width - 1)) ? lane : source, at);
}
template <class T> T __shfl_xor_sync(unsigned mask, T v, int lane_mask, int width = 32, HP_AT) {
  int lane = (int)hp::current->lane, source = lane ^ lane_mask;
  return hp::shuffle(hp::Op::shuffle_xor, mask, v, source > (lane | (width - 1)) ? lane : source, at);
}
template <class T> unsigned __match_any_sync(unsigned mask, T v, HP_AT) {
  return (unsigned)hp::collective(hp::Op::match_any, mask, hp::to_bits(v), 0, at);
}
template <class T> unsigned __match_all_sync(unsigned mask, T v, int *same, HP_AT) {
  unsigned found = (unsigned)hp::collective(hp::Op::match_all, mask, hp::to_bits(v), 0, at);
  *same = found != 0;
  return found;
}
#undef HP_AT
