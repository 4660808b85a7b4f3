// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "core/charge/triangle_frame.h"

namespace geond::charge {

// Two cells that act on each other from afar: where their vectors begin, in steps of kPadding numbers, and which of the
// eight reflections their distance is.
struct CellPair {
  int target, source;
  int reflection;
};

// The inner loops, compiled once for each instruction set and chosen when the program runs.
struct Kernels {
  const char* name;

  // The loops of both precisions. Vectors of harmonics (harmonics.h) are padded to a multiple of kPadding numbers; so
  // are the points of a leaf, with charges 0.
  template <typename Real>
  struct Loops {
    // out[i] = integral over the triangle of dS'/|r_i - r'| at n points r_i = (x[i], y[i], z[i]). In double precision
    // the same bits from every instruction set; in single precision good to some 1e-6 of the greatest, if the triangle
    // lies near the origin and the points near it.
    void (*triangle_potential)(const TriangleFrameOf<Real>& triangle, const Real* x, const Real* y, const Real* z,
                               int n, Real* out);

    // y += A x for a column-major block of `rows` by `columns`. Up to kPadding numbers behind the block are read.
    void (*multiply)(const Real* A, int rows, std::ptrdiff_t columns, const Real* x, Real* y);

    // Column s of a column-major block of `rows` by `sources`: out[i] = sum over g of weight_g/|r_i - shift - p_g|, the
    // `points` points of source s standing one after another. x, y, z are padded.
    void (*point_columns)(int rows, const Real* x, const Real* y, const Real* z, const Real* shift, int sources,
                          int points, const Real* px, const Real* py, const Real* pz, const Real* weight, Real* out);

    // Lists the i < n with |r_i - centre|^2 < reach_squared, n padded in memory, and returns how many there are.
    int (*within_reach)(int n, const Real* x, const Real* y, const Real* z, const Real* centre, Real reach_squared,
                        int* which);

    // U[j * n + i] = U_j(x[i], y[i], z[i]), n padded.
    void (*harmonics)(int order, int n, const Real* x, const Real* y, const Real* z, Real* U);

    // Y += K X for the first `rows` rows, a multiple of kPadding, and `columns` columns of K, column-major, a column
    // every `stride` numbers.
    void (*translate)(const Real* K, int columns, int rows, int stride, const Real* X, Real* Y);

    // For each pair, target += S K S source with S the diagonal signs of its reflection and K the matrix between
    // expansions of `order`; of K what takes a degree n to a degree k with n + k > order + kDegreesBeyond counts as
    // nothing, in whole blocks of kPadding rows. M and L hold the vectors of all cells. No two pairs share a target.
    void (*translate_pairs)(const Real* K, int order, int stride, const CellPair* pairs, int count,
                            const Real* const* signs, const Real* M, Real* L);
  };
  Loops<float> single_precision;
  Loops<double> double_precision;

  // The last `own` rows of the inverse of an m by m matrix A, column-major, `own` by m. M holds the transpose of A row
  // by row in rows of `width` numbers, width >= m + own and a multiple of kPadding, the rest of each row zero; it is
  // destroyed. Elimination without pivoting, which the potential's matrix bears. False if a pivot vanishes.
  bool (*inverse_rows)(float* M, int m, int own, int width, float* rows);
};

constexpr int kDegreesBeyond = 2;  // with 2 the errors grow by 2 to 8 %, for half the work
constexpr int kPadding = 16;
constexpr int Padded(int n) { return (n + kPadding - 1) / kPadding * kPadding; }

template <typename Real>
const Kernels::Loops<Real>& LoopsOf(const Kernels& kernels) {
  if constexpr (sizeof(Real) == sizeof(float)) {
    return kernels.single_precision;
  } else {
    return kernels.double_precision;
  }
}

// The best that this machine can run, and all that it can run (the plainest first).
const Kernels& BestKernels();
std::span<const Kernels* const> UsableKernels();

}  // namespace geond::charge
