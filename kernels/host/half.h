// __half and __half2: storage, conversions and arithmetic, every result rounded once.
#pragma once
#include "language.h"

namespace hp {

// Nearest half, ties to even. NaN becomes NVIDIA's 0x7fff.
inline uint16_t half_bits(float f) {
  uint32_t x;
  memcpy(&x, &f, 4);
  uint32_t sign = x >> 16 & 0x8000u;
  x &= 0x7fffffffu;
  if (x > 0x7f800000u) return 0x7fff;
  if (x >= 0x477ff000u) return (uint16_t)(sign | 0x7c00u);  // 65520 and more
  if (x < 0x38800000u) {                                    // subnormal: adding 1/2 rounds at 2^-24
    float a;
    memcpy(&a, &x, 4);
    a += 0.5f;
    memcpy(&x, &a, 4);
    return (uint16_t)(sign | (x - 0x3f000000u));
  }
  return (uint16_t)(sign | ((x - 0x38000000u + 0xfffu + (x >> 13 & 1)) >> 13));
}
// The next half towards zero.
inline uint16_t half_bits_toward_zero(float f) {
  uint32_t x;
  memcpy(&x, &f, 4);
  uint32_t sign = x >> 16 & 0x8000u;
  x &= 0x7fffffffu;
  if (x > 0x7f800000u) return 0x7fff;
  if (x == 0x7f800000u) return (uint16_t)(sign | 0x7c00u);
  if (x >= 0x47800000u) return (uint16_t)(sign | 0x7bffu);
  if (x >= 0x38800000u) return (uint16_t)(sign | (x - 0x38000000u) >> 13);
  float a;
  memcpy(&a, &x, 4);
  return (uint16_t)(sign | (uint32_t)(a * 0x1p24f));
}
inline float half_value(uint16_t h) {
  uint32_t sign = (uint32_t)(h & 0x8000) << 16, exponent = h >> 10 & 31, fraction = h & 0x3ff, x;
  if (exponent == 31) x = 0x7f800000u | fraction << 13;
  else if (exponent) x = (exponent + 112) << 23 | fraction << 13;
  else {
    float f = (float)fraction * 0x1p-24f;
    memcpy(&x, &f, 4);
  }
  x |= sign;
  float f;
  memcpy(&f, &x, 4);
  return f;
}
// Nearest half of a double. The sum below is rounded to odd first, so that rounding twice equals rounding once.
inline uint16_t half_bits_of_sum(double a, double b) {
  double s = a + b, t = s - a, rest = (a - (s - t)) + (b - t);
  if (rest != 0 && std::isfinite(s)) {
    uint64_t x;
    memcpy(&x, &s, 8);
    if (!(x & 1)) x += (rest > 0) == (s > 0) ? 1 : -1;
    memcpy(&s, &x, 8);
  }
  // To odd again, at float's precision.
  float f = (float)s;
  if ((double)f != s && std::isfinite(f)) {
    uint32_t x;
    memcpy(&x, &f, 4);
    if (!(x & 1)) x += ((double)f < s) == (f > 0) ? 1 : -1;
    memcpy(&f, &x, 4);
  }
  return half_bits(f);
}
// Bits of the nearest tf32 number, ties away from zero (cvt.rna).
inline uint32_t tf32_bits(float f) {
  uint32_t x;
  memcpy(&x, &f, 4);
  return (x & 0x7f800000u) == 0x7f800000u ? x : (x + 0x1000u) & 0xffffe000u;
}

}  // namespace hp

struct __half {
  uint16_t bits;
};
struct alignas(4) __half2 {
  __half x, y;
};
using half = __half;
using half2 = __half2;

inline __half __float2half_rn(float f) { return {hp::half_bits(f)}; }
inline __half __float2half(float f) { return {hp::half_bits(f)}; }
inline __half __float2half_rz(float f) { return {hp::half_bits_toward_zero(f)}; }
inline float __half2float(__half h) { return hp::half_value(h.bits); }
inline unsigned short __half_as_ushort(__half h) { return h.bits; }
inline __half __ushort_as_half(unsigned short bits) { return {bits}; }
// Sums, differences, products and quotients of halves are exact enough in float for one more rounding to be harmless
// (24 >= 2 * 11 + 2 bits).
inline __half __hadd(__half a, __half b) { return __float2half_rn(__half2float(a) + __half2float(b)); }
inline __half __hsub(__half a, __half b) { return __float2half_rn(__half2float(a) - __half2float(b)); }
inline __half __hmul(__half a, __half b) { return __float2half_rn(__half2float(a) * __half2float(b)); }
inline __half __hdiv(__half a, __half b) { return __float2half_rn(__half2float(a) / __half2float(b)); }
inline __half __hfma(__half a, __half b, __half c) {
  return {hp::half_bits_of_sum((double)__half2float(a) * __half2float(b), __half2float(c))};
}
inline __half __hneg(__half a) { return {(uint16_t)(a.bits ^ 0x8000)}; }

inline __half2 __halves2half2(__half a, __half b) { return {a, b}; }
inline __half2 __half2half2(__half a) { return {a, a}; }
inline __half2 __floats2half2_rn(float a, float b) { return {__float2half_rn(a), __float2half_rn(b)}; }
inline __half2 __float22half2_rn(float2 v) { return __floats2half2_rn(v.x, v.y); }
inline float2 __half22float2(__half2 h) { return {__half2float(h.x), __half2float(h.y)}; }
inline __half __low2half(__half2 h) { return h.x; }
inline __half __high2half(__half2 h) { return h.y; }
inline float __low2float(__half2 h) { return __half2float(h.x); }
inline float __high2float(__half2 h) { return __half2float(h.y); }
inline __half2 __hadd2(__half2 a, __half2 b) { return {__hadd(a.x, b.x), __hadd(a.y, b.y)}; }
inline __half2 __hsub2(__half2 a, __half2 b) { return {__hsub(a.x, b.x), __hsub(a.y, b.y)}; }
inline __half2 __hmul2(__half2 a, __half2 b) { return {__hmul(a.x, b.x), __hmul(a.y, b.y)}; }
inline __half2 __hfma2(__half2 a, __half2 b, __half2 c) { return {__hfma(a.x, b.x, c.x), __hfma(a.y, b.y, c.y)}; }
