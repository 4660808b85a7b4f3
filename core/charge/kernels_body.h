// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>

#include "core/charge/kernels.h"
#include "core/charge/potential_formula.h"

// The inner loops in packs. Included by one file for each instruction set; internal linkage as in lanes.h.
namespace geond::charge {
namespace {

void TrianglePotentialAt(const TriangleFrame& triangle, const double* x, const double* y, const double* z, int n,
                         double* out) {
  int i = 0;
  for (; i + kDoubles <= n; i += kDoubles) {
    DoublePack px, py, pz;
    std::memcpy(&px, x + i, sizeof px);
    std::memcpy(&py, y + i, sizeof py);
    std::memcpy(&pz, z + i, sizeof pz);
    const DoublePack value = TrianglePotentialFormula<DoublePack>(triangle, px, py, pz);
    std::memcpy(out + i, &value, sizeof value);
  }
  if (i == n) return;
  DoublePack px = {}, py = {}, pz = {};
  for (int lane = 0; lane < kDoubles; ++lane) {
    const int last = i + lane < n ? i + lane : n - 1;
    px[lane] = x[last], py[lane] = y[last], pz[lane] = z[last];
  }
  const DoublePack value = TrianglePotentialFormula<DoublePack>(triangle, px, py, pz);
  for (int lane = 0; i + lane < n; ++lane) out[i + lane] = value[lane];
}

template <typename Real>
struct PackOf;
template <>
struct PackOf<double> { using type = DoublePack; };
template <>
struct PackOf<float> { using type = FloatPack; };

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

// A strip of kPacks packs of rows stays in registers while the columns go by.
template <int kPacks, typename Real>
inline void MultiplyStrip(const Real* A, int columns, int stride, const Real* x, Real* y) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = sizeof(Pack) / sizeof(Real);
  Pack sum[kPacks];
  for (int p = 0; p < kPacks; ++p) sum[p] = Load<Pack>(y + p * kLanes);
  for (int k = 0; k < columns; ++k, A += stride) {
    for (int p = 0; p < kPacks; ++p) sum[p] += Load<Pack>(A + p * kLanes) * x[k];
  }
  for (int p = 0; p < kPacks; ++p) Store(y + p * kLanes, sum[p]);
}

template <typename Real>
void Multiply(const Real* A, int rows, int columns, int stride, const Real* x, Real* y) {
  constexpr int kLanes = kPackBytes / sizeof(Real);
  int row = 0;
  for (; row + 8 * kLanes <= rows; row += 8 * kLanes) MultiplyStrip<8>(A + row, columns, stride, x, y + row);
  for (; row + kLanes <= rows; row += kLanes) MultiplyStrip<1>(A + row, columns, stride, x, y + row);
  for (; row < rows; ++row) {
    Real sum = y[row];
    for (int k = 0; k < columns; ++k) sum += A[static_cast<std::ptrdiff_t>(k) * stride + row] * x[k];
    y[row] = sum;
  }
}

constexpr Kernels MakeKernels(const char* name) {
  Kernels kernels{};
  kernels.name = name;
  kernels.triangle_potential = TrianglePotentialAt;
  kernels.multiply_double = Multiply<double>;
  return kernels;
}

}  // namespace
}  // namespace geond::charge
