// Atomics, in CUDA's own overloads only: a call that nvcc would refuse must not build here. All are relaxed, as on the GPU.
#pragma once
#include "runtime.h"

namespace hp {

// Replaces *p by f(*p); the old value.
template <class T, class F> T update(T *p, F f) {
  T old = __atomic_load_n(p, __ATOMIC_RELAXED), next;
  do next = f(old);
  while (next != old && !__atomic_compare_exchange_n(p, &old, next, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED));
  return old;
}
// The same for a floating-point number, whose bits `U` are exchanged.
template <class U, class T, class F> T update_bits(T *p, F f) {
  static_assert(sizeof(U) == sizeof(T));
  U *bits = reinterpret_cast<U *>(p), old = __atomic_load_n(bits, __ATOMIC_RELAXED), next;
  T value;
  do {
    memcpy(&value, &old, sizeof value);
    value = f(value);
    memcpy(&next, &value, sizeof value);
  } while (!__atomic_compare_exchange_n(bits, &old, next, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED));
  memcpy(&value, &old, sizeof value);
  return value;
}

}  // namespace hp

#define HP_ATOMIC_INT(T)                                                                                 \
  inline T atomicExch(T *p, T v) { return __atomic_exchange_n(p, v, __ATOMIC_RELAXED); }                 \
  inline T atomicAnd(T *p, T v) { return __atomic_fetch_and(p, v, __ATOMIC_RELAXED); }                   \
  inline T atomicOr(T *p, T v) { return __atomic_fetch_or(p, v, __ATOMIC_RELAXED); }                     \
  inline T atomicXor(T *p, T v) { return __atomic_fetch_xor(p, v, __ATOMIC_RELAXED); }                   \
  inline T atomicAdd(T *p, T v) { return __atomic_fetch_add(p, v, __ATOMIC_RELAXED); }                   \
  inline T atomicCAS(T *p, T expected, T v) {                                                            \
    __atomic_compare_exchange_n(p, &expected, v, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);             \
    return expected;                                                                                     \
  }
#define HP_ATOMIC_ORDER(T)                                                                               \
  inline T atomicMin(T *p, T v) { return hp::update(p, [=](T old) { return v < old ? v : old; }); }      \
  inline T atomicMax(T *p, T v) { return hp::update(p, [=](T old) { return v > old ? v : old; }); }
HP_ATOMIC_INT(int)
HP_ATOMIC_INT(unsigned)
HP_ATOMIC_INT(unsigned long long)
HP_ATOMIC_ORDER(int)
HP_ATOMIC_ORDER(unsigned)
HP_ATOMIC_ORDER(unsigned long long)
HP_ATOMIC_ORDER(long long)
#undef HP_ATOMIC_INT
#undef HP_ATOMIC_ORDER

inline int atomicSub(int *p, int v) { return __atomic_fetch_sub(p, v, __ATOMIC_RELAXED); }
inline unsigned atomicSub(unsigned *p, unsigned v) { return __atomic_fetch_sub(p, v, __ATOMIC_RELAXED); }
inline unsigned atomicInc(unsigned *p, unsigned last) {
  return hp::update(p, [=](unsigned old) { return old >= last ? 0u : old + 1; });
}
inline unsigned atomicDec(unsigned *p, unsigned last) {
  return hp::update(p, [=](unsigned old) { return old == 0 || old > last ? last : old - 1; });
}
inline float atomicExch(float *p, float v) {
  return hp::update_bits<uint32_t>(p, [=](float) { return v; });
}
inline float atomicAdd(float *p, float v) {
  return hp::update_bits<uint32_t>(p, [=](float old) { return old + v; });
}
inline double atomicAdd(double *p, double v) {
  return hp::update_bits<uint64_t>(p, [=](double old) { return old + v; });
}
