// Scalar intrinsics. Needs -ffp-contract=off: `a * b + c` is two roundings here; kernels that want one write __fmaf_rn.
#pragma once
#include "language.h"

#define HP_BITS(NAME, A, B)    \
  inline B NAME(A a) {         \
    B b;                       \
    memcpy(&b, &a, sizeof b);  \
    return b;                  \
  }
HP_BITS(__float_as_uint, float, unsigned)
HP_BITS(__float_as_int, float, int)
HP_BITS(__uint_as_float, unsigned, float)
HP_BITS(__int_as_float, int, float)
HP_BITS(__double_as_longlong, double, long long)
HP_BITS(__longlong_as_double, long long, double)
#undef HP_BITS

inline float __fadd_rn(float a, float b) { return a + b; }
inline float __fsub_rn(float a, float b) { return a - b; }
inline float __fmul_rn(float a, float b) { return a * b; }
inline float __fdiv_rn(float a, float b) { return a / b; }
inline float __frcp_rn(float a) { return 1.0f / a; }
inline float __fsqrt_rn(float a) { return __builtin_sqrtf(a); }
inline float __fmaf_rn(float a, float b, float c) { return __builtin_fmaf(a, b, c); }
inline double __dadd_rn(double a, double b) { return a + b; }
inline double __dsub_rn(double a, double b) { return a - b; }
inline double __dmul_rn(double a, double b) { return a * b; }
inline double __ddiv_rn(double a, double b) { return a / b; }
inline double __dsqrt_rn(double a) { return __builtin_sqrt(a); }
inline double __fma_rn(double a, double b, double c) { return __builtin_fma(a, b, c); }
// The GPU approximates these by up to 2 ulp; here they are rounded correctly or nearly so.
inline float rsqrtf(float a) { return (float)(1.0 / __builtin_sqrt((double)a)); }
inline float __frsqrt_rn(float a) { return rsqrtf(a); }
inline float __fdividef(float a, float b) { return a / b; }
inline float __saturatef(float a) { return a > 0 ? (a < 1 ? a : 1.0f) : 0.0f; }
// Directed rounding of sums and products, from the exact double.
namespace hp {
inline float round_down(double exact) {
  float f = (float)exact;
  return (double)f > exact ? __builtin_nextafterf(f, -__builtin_inff()) : f;
}
inline float round_up(double exact) { return -round_down(-exact); }
}  // namespace hp
inline float __fmul_rd(float a, float b) { return hp::round_down((double)a * b); }
inline float __fmul_ru(float a, float b) { return hp::round_up((double)a * b); }
inline float __double2float_rn(double a) { return (float)a; }
inline float __double2float_rd(double a) { return hp::round_down(a); }
inline float __double2float_ru(double a) { return hp::round_up(a); }

// Conversions saturate, and NaN is 0.
inline int __float2int_rz(float a) {
  if (a != a) return 0;
  return a >= 2147483648.0f ? 2147483647 : a <= -2147483648.0f ? -2147483647 - 1 : (int)a;
}
inline int __float2int_rn(float a) { return __float2int_rz(__builtin_rintf(a)); }
inline int __float2int_rd(float a) { return __float2int_rz(__builtin_floorf(a)); }
inline int __float2int_ru(float a) { return __float2int_rz(__builtin_ceilf(a)); }
inline unsigned __float2uint_rz(float a) { return !(a > 0) ? 0 : a >= 4294967296.0f ? ~0u : (unsigned)a; }
inline unsigned __float2uint_rn(float a) { return __float2uint_rz(__builtin_rintf(a)); }
inline float __int2float_rn(int a) { return (float)a; }
inline float __uint2float_rn(unsigned a) { return (float)a; }

inline int __popc(unsigned a) { return __builtin_popcount(a); }
inline int __popcll(unsigned long long a) { return __builtin_popcountll(a); }
inline int __clz(int a) { return a ? __builtin_clz((unsigned)a) : 32; }
inline int __clzll(long long a) { return a ? __builtin_clzll((unsigned long long)a) : 64; }
inline int __ffs(int a) { return __builtin_ffs(a); }
inline int __ffsll(long long a) { return __builtin_ffsll(a); }
inline unsigned __brev(unsigned a) {
  unsigned r = 0;
  for (int i = 0; i < 32; i++) r |= (a >> i & 1) << (31 - i);
  return r;
}
inline unsigned __umulhi(unsigned a, unsigned b) { return (unsigned)((unsigned long long)a * b >> 32); }
inline int __mulhi(int a, int b) { return (int)((long long)a * b >> 32); }
// Bytes of (y, x), chosen by the low three bits of each of four nibbles; the fourth replicates the sign.
inline unsigned __byte_perm(unsigned x, unsigned y, unsigned selector) {
  unsigned long long both = (unsigned long long)y << 32 | x;
  unsigned r = 0;
  for (int i = 0; i < 4; i++) {
    unsigned s = selector >> 4 * i & 15, byte = (unsigned)(both >> 8 * (s & 7)) & 255;
    r |= (s & 8 ? (byte & 128 ? 255u : 0u) : byte) << 8 * i;
  }
  return r;
}
inline unsigned __funnelshift_l(unsigned low, unsigned high, unsigned shift) {
  return (unsigned)(((unsigned long long)high << 32 | low) << (shift & 31) >> 32);
}
inline unsigned __funnelshift_r(unsigned low, unsigned high, unsigned shift) {
  return (unsigned)(((unsigned long long)high << 32 | low) >> (shift & 31));
}

#define HP_MIN_MAX(T)                              \
  inline T min(T a, T b) { return b < a ? b : a; } \
  inline T max(T a, T b) { return a < b ? b : a; }
HP_MIN_MAX(int)
HP_MIN_MAX(unsigned)
HP_MIN_MAX(long long)
HP_MIN_MAX(unsigned long long)
#undef HP_MIN_MAX
// A NaN loses against a number, as in CUDA.
inline float min(float a, float b) { return __builtin_fminf(a, b); }
inline float max(float a, float b) { return __builtin_fmaxf(a, b); }
inline double min(double a, double b) { return __builtin_fmin(a, b); }
inline double max(double a, double b) { return __builtin_fmax(a, b); }
