// Tensor-core arithmetic: mma.sync with f32 sums.
//
// Model (Fasi, Higham, Mikaitis, Pranesh, "Numerical behavior of NVIDIA tensor cores", 2021; Khattak & Mikaitis,
// arXiv 2512.07004, 2025): products are exact; a group of products and the accumulator are aligned to their largest exponent
// and cut off below 23 + `extra` bits after its point; the sum is exact; the result is cut off to f32, subnormals included.
// A product's exponent is the sum of its factors' exponents, a carry of the significands (1 <= p < 4) not counted; zeros do
// not count. Groups follow each other along K; the products of a sparse tile are one. The model gives the recorded outputs of A100, A2, Ada and L40S (f16 and
// tf32), H100, H200 and B200 (tf32, K = 4), 5000 of 5000 each. Not recorded, so assumed: f16 on sm_90, subnormal results, and
// all of sparse tiles.
#include <math.h>
#include <string.h>

#include "block.h"

namespace hp {

struct Operands {
  Tile tile;
  const uint32_t *a, *b;
  const float *c;
  float *d;
  uint32_t metadata;
};
struct Model {
  int f16_group, tf32_group, extra;
};
constexpr Model MODELS[2] = {{8, 4, 1}, {16, 8, 2}};  // sm_80 to sm_89, sm_90 and later

constexpr int ROWS = 16, COLUMNS = 8, MAX_K = 16;
constexpr int ZERO_EXPONENT = -1000;   // below that of any product
constexpr int LEAST_EXPONENT = -400;   // of an all-zero group; keeps the scale a normal double
constexpr uint32_t NAN_BITS = 0x7fffffff;  // NVIDIA's

// How an operand is stored. The hardware reads the upper 19 bits of a tf32.
struct Format {
  int fraction_at, exponent_at, top, sign_at;
};
constexpr Format F16 = {0, 10, 31, 15}, TF32 = {13, 23, 255, 31};

struct Matrices {
  Tile tile;
  int k;
  uint32_t a_bits[ROWS][MAX_K], b_bits[MAX_K][COLUMNS];
  // value = significand * 2^(exponent - 10). Inf and NaN, which sum_specially() handles, count as zero.
  int a[ROWS][MAX_K], a_exponent[ROWS][MAX_K];
  int b[MAX_K][COLUMNS], b_exponent[MAX_K][COLUMNS];
  float c[ROWS][COLUMNS];
  bool special_row[ROWS], special_column[COLUMNS];
};

// Without branches, as signs and zeros come in no order. True for Inf and NaN.
static inline bool decode(const Format &f, uint32_t bits, int *significand, int *exponent) {
  int biased = bits >> f.exponent_at & f.top, fraction = bits >> f.fraction_at & 0x3ff, sign = -(int)(bits >> f.sign_at & 1);
  bool special = biased == f.top;
  int s = (fraction | (biased ? 0x400 : 0)) & -(int)!special;
  *significand = (s ^ sign) - sign;
  *exponent = s ? (biased ? biased : 1) - f.top / 2 : ZERO_EXPONENT;
  return special;
}
template <Format f> static void decode_all(Matrices *m) {
  for (int row = 0; row < ROWS; row++) {
    int special = 0;
    for (int k = 0; k < m->k; k++) special |= decode(f, m->a_bits[row][k], &m->a[row][k], &m->a_exponent[row][k]);
    m->special_row[row] = special;
  }
  int special[COLUMNS] = {};
  for (int k = 0; k < m->k; k++)
    for (int n = 0; n < COLUMNS; n++) special[n] |= decode(f, m->b_bits[k][n], &m->b[k][n], &m->b_exponent[k][n]);
  for (int n = 0; n < COLUMNS; n++) m->special_column[n] = special[n];
}

// Registers of a lane to matrices; the layouts stand in compat.cuh.
static void gather(Matrices *m, const Operands &o, int lane, uint32_t metadata) {
  int g = lane / 4, t = lane % 4;
  for (int half = 0; half < 2; half++) {
    if (m->tile == Tile::tf32_k8) {
      m->a_bits[g][t + 4 * half] = o.a[2 * half];
      m->a_bits[g + 8][t + 4 * half] = o.a[2 * half + 1];
      m->b_bits[t + 4 * half][g] = o.b[half];
      continue;
    }
    if (m->tile == Tile::f16_k16_sparse) {
      // Of row g + 8 half: which of the columns from 4t on.
      uint32_t columns = metadata >> (16 * half + 4 * t) & 15;
      m->a_bits[g + 8 * half][4 * t + (columns & 3)] = o.a[half] & 0xffff;
      m->a_bits[g + 8 * half][4 * t + (columns >> 2)] = o.a[half] >> 16;
    }
    for (int block = 0; block < m->k / 8; block++) {
      int k = 8 * block + 2 * t + half, shift = 16 * half;
      m->b_bits[k][g] = o.b[block] >> shift & 0xffff;
      if (m->tile == Tile::f16_k16_sparse) continue;
      m->a_bits[g][k] = o.a[2 * block] >> shift & 0xffff;
      m->a_bits[g + 8][k] = o.a[2 * block + 1] >> shift & 0xffff;
    }
  }
  for (int r = 0; r < 4; r++) m->c[g + 8 * (r / 2)][2 * t + r % 2] = o.c[r];
}
static void scatter(const Matrices *m, const Operands &o, int lane) {
  int g = lane / 4, t = lane % 4;
  for (int r = 0; r < 4; r++) o.d[r] = m->c[g + 8 * (r / 2)][2 * t + r % 2];
}

// Cuts a sum of at most 33 bits times a power of two off to f32, towards zero; too large is infinite.
static inline float cut_off(double sum, double scale) {
  uint64_t bits;
  memcpy(&bits, &sum, 8);
  bits &= ~((1ull << 29) - 1);
  memcpy(&sum, &bits, 8);
  return (float)(sum * scale);
}
static float cut_off_subnormal(double sum, double scale) { return (float)(trunc(sum * scale * 0x1p149) * 0x1p-149); }

// One row of sums over K from `from` to `to`. `Sum` is wide enough for the terms: 8 products and c in 31 bits, 16 need more.
template <class Sum>
static inline __attribute__((always_inline)) void add_group(const Matrices *m, int row, int from, int to, int extra,
                                                            float *acc) {
  int top[COLUMNS], c[COLUMNS], c_exponent[COLUMNS];
  Sum sum[COLUMNS];
  double scaled[COLUMNS], scale[COLUMNS];
  for (int n = 0; n < COLUMNS; n++) {
    uint32_t u;
    memcpy(&u, acc + n, 4);
    int biased = u >> 23 & 255, s = (int)(u & 0x7fffff) | (biased ? 0x800000 : 0);
    c[n] = u >> 31 ? -s : s;
    c_exponent[n] = s ? (biased ? biased : 1) - 127 : ZERO_EXPONENT;
    top[n] = c_exponent[n] > LEAST_EXPONENT ? c_exponent[n] : LEAST_EXPONENT;
  }
  for (int k = from; k < to; k++)
    for (int n = 0; n < COLUMNS; n++) {
      int e = m->a_exponent[row][k] + m->b_exponent[k][n];
      top[n] = e > top[n] ? e : top[n];
    }
  for (int n = 0; n < COLUMNS; n++) {
    int shift = top[n] - c_exponent[n], s = (c[n] < 0 ? -c[n] : c[n]) << extra >> (shift > 31 ? 31 : shift);
    sum[n] = c[n] < 0 ? -s : s;
  }
  for (int k = from; k < to; k++)
    for (int n = 0; n < COLUMNS; n++) {
      // A product has 20 bits after its point.
      int p = m->a[row][k] * m->b[k][n], shift = top[n] - (m->a_exponent[row][k] + m->b_exponent[k][n]);
      int s = (p < 0 ? -p : p) << (3 + extra) >> (shift > 31 ? 31 : shift);
      sum[n] += p < 0 ? -s : s;
    }
  for (int n = 0; n < COLUMNS; n++) {
    uint64_t bits = (uint64_t)(1023 + top[n] - 23 - extra) << 52;
    memcpy(&scale[n], &bits, 8);
    scaled[n] = (double)sum[n];
  }
  for (int n = 0; n < COLUMNS; n++) {
    float r = cut_off(scaled[n], scale[n]);
    if (fabs(scaled[n] * scale[n]) < 0x1p-126) r = cut_off_subnormal(scaled[n], scale[n]);
    acc[n] = isfinite(acc[n]) ? r : acc[n];
  }
}

// The loops over columns are written for vectors; which ones is known at run time.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(HP_TSAN) && !defined(HP_ASAN)
__attribute__((target_clones("avx2", "default")))
#endif
static void multiply(Matrices *m, int group, int extra) {
  for (int row = 0; row < ROWS; row++)
    for (int k = 0; k < m->k; k += group) {
      if (group > 8) add_group<int64_t>(m, row, k, k + group, extra, m->c[row]);
      else add_group<int32_t>(m, row, k, k + group, extra, m->c[row]);
    }
}

// An element that an Inf or NaN takes part in: Inf or NaN by IEEE's rules, whatever else there is.
static float sum_specially(const Matrices *m, int row, int column, float c) {
  double sum = c;
  auto value = [m](uint32_t bits) -> double {
    return m->tile == Tile::tf32_k8 ? __uint_as_float(bits & 0xffffe000u) : half_value((uint16_t)bits);
  };
  for (int k = 0; k < m->k; k++) {
    // What a sparse row leaves out is not multiplied.
    if (m->tile == Tile::f16_k16_sparse && m->a_bits[row][k] == 0) continue;
    sum += value(m->a_bits[row][k]) * value(m->b_bits[k][column]);
  }
  float f = (float)sum;
  if (isnan(sum)) memcpy(&f, &NAN_BITS, 4);
  return f;
}

void evaluate_mma(Warp *w, const Group &g) {
  if (g.arrived != ~0u)
    fail(FaultKind::incomplete_warp, g.at, "mma.sync needs all 32 lanes of a warp; those of mask %08x are here", g.arrived);
  auto operands = [&](int lane) -> const Operands & { return *reinterpret_cast<const Operands *>(w->lanes[lane].value); };
  const Model &model = MODELS[w->lanes[0].block->run->launch.tensor_cores != 0];
  Matrices m;
  m.tile = operands(0).tile;
  bool sparse = m.tile == Tile::f16_k16_sparse;
  m.k = m.tile == Tile::f16_k16 || sparse ? 16 : 8;
  if (sparse) memset(m.a_bits, 0, sizeof m.a_bits);
  for (int lane = 0; lane < 32; lane++) gather(&m, operands(lane), lane, operands(lane & ~3).metadata);
  if (m.tile == Tile::tf32_k8) decode_all<TF32>(&m);
  else decode_all<F16>(&m);
  float c[ROWS][COLUMNS];
  memcpy(c, m.c, sizeof c);
  int group = sparse ? m.k : m.tile == Tile::tf32_k8 ? model.tf32_group : model.f16_group;
  multiply(&m, group < m.k ? group : m.k, model.extra);
  for (int row = 0; row < ROWS; row++)
    for (int column = 0; column < COLUMNS; column++)
      if (m.special_row[row] || m.special_column[column] || !isfinite(c[row][column]))
        m.c[row][column] = sum_specially(&m, row, column, c[row][column]);
  for (int lane = 0; lane < 32; lane++) scatter(&m, operands(lane), lane);
}

void mma(Tile tile, float (&d)[4], const uint32_t *a, const uint32_t *b, const float (&c)[4], Site at, uint32_t metadata) {
  Operands o{tile, a, b, c, d, metadata};
  collective(Op::mma, ~0u, reinterpret_cast<uint64_t>(&o), 0, at);
}

}  // namespace hp
