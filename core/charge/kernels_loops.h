// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "core/charge/kernels.h"
#include "core/charge/lanes.h"

// The loops of the fast solver in packs, for float and double (kernels.h says what each does). Internal linkage as in
// lanes.h.
namespace geond::charge {
namespace {

template <typename Real>
struct PackOf;
template <>
struct PackOf<double> {
  using type = DoublePack;
};
template <>
struct PackOf<float> {
  using type = FloatPack;
};

template <typename Pack, typename Real>
inline Pack Load(const Real* from) {
  Pack pack;
  std::memcpy(&pack, from, sizeof pack);
  return pack;
}

template <typename Pack, typename Real>
inline void Store(Real* to, Pack pack) {
  std::memcpy(to, &pack, sizeof pack);
}

// a * b + c, rounded once where the machine can: these loops promise their sums to rounding, not to the bit.
template <typename Pack, typename Factor>
inline Pack MultiplyAdd(Pack a, Factor b, Pack c) {
  const Pack factor = b - Pack{};  // a number goes into every lane
#if defined(__AVX512F__)
  if constexpr (sizeof(a[0]) == sizeof(float)) {
    return _mm512_fmadd_ps(a, factor, c);
  } else {
    return _mm512_fmadd_pd(a, factor, c);
  }
#elif defined(__AVX2__)
  if constexpr (sizeof(a[0]) == sizeof(float)) {
    return _mm256_fmadd_ps(a, factor, c);
  } else {
    return _mm256_fmadd_pd(a, factor, c);
  }
#else
  return a * factor + c;
#endif
}

// A strip of kPacks packs of rows stays in registers while the columns go by, two at a time. The last pack of a strip
// may reach into the next column; what it finds there is computed on and dropped.
template <int kPacks, typename Real>
inline void MultiplyStrip(const Real* A, int rows, int stride, std::ptrdiff_t columns, const Real* x, Real* y) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  Pack even[kPacks] = {}, odd[kPacks] = {};
  std::ptrdiff_t k = 0;
  for (; k + 2 <= columns; k += 2, A += 2 * stride) {
    for (int p = 0; p < kPacks; ++p) even[p] = MultiplyAdd(Load<Pack>(A + p * kLanes), x[k], even[p]);
    for (int p = 0; p < kPacks; ++p) odd[p] = MultiplyAdd(Load<Pack>(A + stride + p * kLanes), x[k + 1], odd[p]);
  }
  if (k < columns) {
    for (int p = 0; p < kPacks; ++p) even[p] = MultiplyAdd(Load<Pack>(A + p * kLanes), x[k], even[p]);
  }
  Real sum[kPacks * kLanes];
  for (int p = 0; p < kPacks; ++p) Store(sum + p * kLanes, even[p] + odd[p]);
  for (int row = 0; row < rows; ++row) y[row] += sum[row];
}

template <typename Real>
void Multiply(const Real* A, int rows, std::ptrdiff_t columns, const Real* x, Real* y) {
  constexpr int kLanes = kPackBytes / sizeof(Real);
  for (int row = 0; row < rows;) {
    const int left = rows - row, packs = (left + kLanes - 1) / kLanes;
    if (packs >= 4) {
      MultiplyStrip<4>(A + row, std::min(left, 4 * kLanes), rows, columns, x, y + row);
      row += 4 * kLanes;
    } else if (packs >= 2) {
      MultiplyStrip<2>(A + row, std::min(left, 2 * kLanes), rows, columns, x, y + row);
      row += 2 * kLanes;
    } else {
      MultiplyStrip<1>(A + row, left, rows, columns, x, y + row);
      row += kLanes;
    }
  }
}

inline DoublePack ReciprocalSqrt(DoublePack x) { return 1.0 / Sqrt(x); }

// The machine's estimate and one step of Newton's.
inline FloatPack ReciprocalSqrt(FloatPack x) {
#if defined(__AVX512F__)
  const FloatPack estimate = _mm512_maskz_rsqrt14_ps(0xffff, x);
#elif defined(__AVX2__)
  const FloatPack estimate = _mm256_rsqrt_ps(x);
#else
  FloatPack estimate = x;
  for (int i = 0; i < kFloats; ++i) estimate[i] = 1.0f / std::sqrt(x[i]);
#endif
  return estimate * (1.5f - 0.5f * x * estimate * estimate);
}

template <int kPoints, typename Real>
inline void PointColumnsOf(int rows, const Real* x, const Real* y, const Real* z, const Real* shift, int sources,
                           const Real* px, const Real* py, const Real* pz, const Real* weight, Real* out) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  const Real* const end = out + static_cast<std::ptrdiff_t>(rows) * sources;
  for (int s = 0; s < sources; ++s, px += kPoints, py += kPoints, pz += kPoints, weight += kPoints, out += rows) {
    Real qx[kPoints], qy[kPoints], qz[kPoints];
    for (int g = 0; g < kPoints; ++g) qx[g] = px[g] + shift[0], qy[g] = py[g] + shift[1], qz[g] = pz[g] + shift[2];
    for (int i = 0; i < rows; i += kLanes) {
      const Pack rx = Load<Pack>(x + i), ry = Load<Pack>(y + i), rz = Load<Pack>(z + i);
      Pack sum = {};
      for (int g = 0; g < kPoints; ++g) {
        const Pack dx = rx - qx[g], dy = ry - qy[g], dz = rz - qz[g];
        const Pack squared = MultiplyAdd(dx, dx, MultiplyAdd(dy, dy, dz * dz)) + Real(1e-30);
        sum = MultiplyAdd(ReciprocalSqrt(squared), weight[g], sum);
      }
      // A column may run over into the next ones, which are written later, but not over the end.
      if (out + i + kLanes <= end) {
        Store(out + i, sum);
      } else {
        Real lanes[kLanes];
        Store(lanes, sum);
        std::memcpy(out + i, lanes, (rows - i) * sizeof(Real));
      }
    }
  }
}

template <typename Real>
void PointColumns(int rows, const Real* x, const Real* y, const Real* z, const Real* shift, int sources, int points,
                  const Real* px, const Real* py, const Real* pz, const Real* weight, Real* out) {
  const auto columns = points == 1   ? PointColumnsOf<1, Real>
                       : points == 3 ? PointColumnsOf<3, Real>
                                     : PointColumnsOf<7, Real>;
  columns(rows, x, y, z, shift, sources, px, py, pz, weight, out);
}

template <typename Real>
int WithinReach(int n, const Real* x, const Real* y, const Real* z, const Real* centre, Real reach_squared,
                int* which) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  int count = 0;
  for (int i = 0; i < n; i += kLanes) {
    const Pack dx = Load<Pack>(x + i) - centre[0], dy = Load<Pack>(y + i) - centre[1],
               dz = Load<Pack>(z + i) - centre[2];
    const Pack squared = dx * dx + dy * dy + dz * dz;
#if defined(__AVX512F__)
    unsigned mask;
    if constexpr (sizeof(Real) == sizeof(float)) {
      mask = _mm512_cmp_ps_mask(squared, Pack{} + reach_squared, _CMP_LT_OQ);
    } else {
      mask = _mm512_cmp_pd_mask(squared, Pack{} + reach_squared, _CMP_LT_OQ);
    }
    for (; mask != 0; mask &= mask - 1) {
      const int lane = __builtin_ctz(mask);
      if (i + lane < n) which[count++] = i + lane;
    }
#else
    for (int lane = 0; lane < kLanes && i + lane < n; ++lane) {
      if (squared[lane] < reach_squared) which[count++] = i + lane;
    }
#endif
  }
  return count;
}

constexpr int kHighestOrder = 20;

// The factors of U_n^m = rise z U_(n-1)^m - fall r^2 U_(n-2)^m.
template <typename Real>
struct HarmonicFactors {
  Real rise[kHighestOrder + 1][kHighestOrder + 1] = {}, fall[kHighestOrder + 1][kHighestOrder + 1] = {};
  constexpr HarmonicFactors() {
    for (int n = 1; n <= kHighestOrder; ++n) {
      for (int m = 0; m < n; ++m) {
        rise[n][m] = static_cast<Real>((2.0 * n - 1.0) / (n * n - m * m));
        fall[n][m] = static_cast<Real>(1.0 / (n * n - m * m));
      }
    }
  }
};

// U(x, y, z) of harmonics.h, a pack of points at a time.
template <typename Pack, typename Real>
inline void RegularHarmonicsOf(int order, Pack x, Pack y, Pack z, Pack* U) {
  static constexpr HarmonicFactors<Real> kFactors;
  const Pack r2 = x * x + y * y + z * z;
  Pack top_re = x * Real(0) + Real(1), top_im = x * Real(0);
  for (int m = 0; m <= order; ++m) {
    if (m > 0) {
      const Real factor = Real(-0.5) / m;
      const Pack re = factor * (x * top_re - y * top_im);
      top_im = factor * (x * top_im + y * top_re);
      top_re = re;
    }
    Pack re1 = top_re, im1 = top_im, re2 = x * Real(0), im2 = re2;
    for (int n = m; n <= order; ++n) {
      if (n > m) {
        const Pack rise = kFactors.rise[n][m] * z, fall = kFactors.fall[n][m] * r2;
        const Pack re = rise * re1 - fall * re2, im = rise * im1 - fall * im2;
        re2 = re1, re1 = re, im2 = im1, im1 = im;
      }
      if (m == 0) {
        U[n * n] = re1;
      } else {
        U[n * n + 2 * m - 1] = re1;
        U[n * n + 2 * m] = im1;
      }
    }
  }
}

template <typename Real>
void Harmonics(int order, int n, const Real* x, const Real* y, const Real* z, Real* out) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real), kMost = (kHighestOrder + 1) * (kHighestOrder + 1);
  Pack U[kMost];
  for (int i = 0; i < n; i += kLanes) {
    RegularHarmonicsOf<Pack, Real>(order, Load<Pack>(x + i), Load<Pack>(y + i), Load<Pack>(z + i), U);
    for (int j = 0; j < (order + 1) * (order + 1); ++j) Store(out + static_cast<std::ptrdiff_t>(j) * n + i, U[j]);
  }
}

// The first kPacks packs of rows of kVectors results, in registers, while the columns from begin to end go by; the
// vectors stand `apart` numbers apart.
template <int kPacks, int kVectors, int kMostPacks, typename Real, typename Pack>
inline void TranslateTile(const Real* K, int begin, int end, int stride, const Real* X, int apart,
                          Pack (&sum)[kVectors][kMostPacks]) {
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  for (int k = begin; k < end; ++k) {
    Pack column[kPacks];
    for (int p = 0; p < kPacks; ++p) column[p] = Load<Pack>(K + k * stride + p * kLanes);
    for (int v = 0; v < kVectors; ++v) {
      for (int p = 0; p < kPacks; ++p) sum[v][p] = MultiplyAdd(column[p], X[v * apart + k], sum[v][p]);
    }
  }
}

template <int kPacks, typename Real>
inline void TranslateRows(const Real* K, int columns, int stride, const Real* X, Real* Y) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  Pack sum[1][kPacks] = {};
  TranslateTile<kPacks>(K, 0, columns, stride, X, 0, sum);
  for (int p = 0; p < kPacks; ++p) Store(Y + p * kLanes, Load<Pack>(Y + p * kLanes) + sum[0][p]);
}

template <typename Real>
void Translate(const Real* K, int columns, int rows, int stride, const Real* X, Real* Y) {
  constexpr int kLanes = kPackBytes / sizeof(Real);
  int row = 0;
  for (; row + 4 * kLanes <= rows; row += 4 * kLanes) TranslateRows<4>(K + row, columns, stride, X, Y + row);
  for (; row + 2 * kLanes <= rows; row += 2 * kLanes) TranslateRows<2>(K + row, columns, stride, X, Y + row);
  for (; row < rows; row += kLanes) TranslateRows<1>(K + row, columns, stride, X, Y + row);
}

// Rows of harmonics, kPadding at a time, and the columns that act on each such block (kernels.h).
struct BlocksOfRows {
  int rows, columns[Padded((kHighestOrder + 1) * (kHighestOrder + 1)) / kPadding];
  explicit BlocksOfRows(int order) : rows(Padded((order + 1) * (order + 1))) {
    for (int block = 0, least = 0; block * kPadding < rows; ++block) {
      while ((least + 1) * (least + 1) <= block * kPadding) ++least;  // the block's first row is of this degree
      const int highest = std::min(order, order + kDegreesBeyond - least);
      columns[block] = highest < 0 ? 0 : (highest + 1) * (highest + 1);
    }
  }
};

// The reflected multipoles of kVectors pairs, side by side; then strips of the results, reflected back and added.
template <int kVectors, typename Real>
inline void TranslatePairsTile(const Real* K, const BlocksOfRows& blocks, int stride, const CellPair* pairs,
                               const Real* const* signs, const Real* M, Real* L) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real), kWide = kPackBytes == 64 ? 4 : 2;
  Real X[kVectors * Padded((kHighestOrder + 1) * (kHighestOrder + 1))];
  for (int v = 0; v < kVectors; ++v) {
    const Real* const from = M + static_cast<std::ptrdiff_t>(pairs[v].source) * kPadding;
    const Real* const sign = signs[pairs[v].reflection];
    for (int j = 0; j < blocks.rows; j += kLanes)
      Store(X + v * blocks.rows + j, Load<Pack>(from + j) * Load<Pack>(sign + j));
  }
  int row = 0;
  const auto strip = [&]<int kPacks>() {
    Pack sum[kVectors][kPacks] = {};
    // The later rows have the fewer columns.
    int done = 0;
    const auto columns = [&]<int kUsed>() {
      const int end = blocks.columns[(row + (kUsed - 1) * kLanes) / kPadding];
      TranslateTile<kUsed>(K + row, done, end, stride, X, blocks.rows, sum);
      done = std::max(done, end);
    };
    if constexpr (kPacks == 4) columns.template operator()<4>();
    if constexpr (kPacks >= 3) columns.template operator()<3>();
    if constexpr (kPacks >= 2) columns.template operator()<2>();
    columns.template operator()<1>();
    for (int v = 0; v < kVectors; ++v) {
      for (int p = 0; p < kPacks; ++p) {
        const int at = row + p * kLanes;
        Real* const to = L + static_cast<std::ptrdiff_t>(pairs[v].target) * kPadding + at;
        Store(to, MultiplyAdd(sum[v][p], Load<Pack>(signs[pairs[v].reflection] + at), Load<Pack>(to)));
      }
    }
    row += kPacks * kLanes;
  };
  while (row + kWide * kLanes <= blocks.rows) strip.template operator()<kWide>();
  if constexpr (kWide == 4) {
    if (row + 3 * kLanes <= blocks.rows) strip.template operator()<3>();
    if (row + 2 * kLanes <= blocks.rows) strip.template operator()<2>();
  }
  if (row < blocks.rows) strip.template operator()<1>();
}

template <typename Real>
void TranslatePairs(const Real* K, int order, int stride, const CellPair* pairs, int count, const Real* const* signs,
                    const Real* M, Real* L) {
  constexpr int kMany = kPackBytes == 64 ? 6 : 5;  // what the registers hold
  const BlocksOfRows blocks(order);
  int i = 0;
  for (; i + kMany <= count; i += kMany) TranslatePairsTile<kMany>(K, blocks, stride, pairs + i, signs, M, L);
  if (i + 4 <= count) TranslatePairsTile<4>(K, blocks, stride, pairs + i, signs, M, L), i += 4;
  if (i + 2 <= count) TranslatePairsTile<2>(K, blocks, stride, pairs + i, signs, M, L), i += 2;
  if (i < count) TranslatePairsTile<1>(K, blocks, stride, pairs + i, signs, M, L);
}

}  // namespace
}  // namespace geond::charge
