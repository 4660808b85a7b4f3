// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/charge/kernels.h"
#include "core/charge/kernels_inverse.h"
#include "core/charge/kernels_loops.h"
#include "core/charge/potential_formula.h"

// The inner loops in packs. Included by one file for each instruction set; internal linkage as in lanes.h.
namespace geond::charge {
namespace {

template <typename Real>
void TrianglePotentialAt(const TriangleFrameOf<Real>& triangle, const Real* x, const Real* y, const Real* z, int n,
                         Real* out) {
  using Pack = typename PackOf<Real>::type;
  constexpr int kLanes = kPackBytes / sizeof(Real);
  int i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    Store(out + i, TrianglePotentialFormula(triangle, Load<Pack>(x + i), Load<Pack>(y + i), Load<Pack>(z + i)));
  }
  if (i == n) return;
  Pack px = {}, py = {}, pz = {};
  for (int lane = 0; lane < kLanes; ++lane) {
    const int last = i + lane < n ? i + lane : n - 1;
    px[lane] = x[last], py[lane] = y[last], pz[lane] = z[last];
  }
  const Pack value = TrianglePotentialFormula(triangle, px, py, pz);
  for (int lane = 0; i + lane < n; ++lane) out[i + lane] = value[lane];
}

template <typename Real>
constexpr Kernels::Loops<Real> MakeLoops() {
  return {TrianglePotentialAt<Real>, Multiply<Real>,  PointColumns<Real>,  WithinReach<Real>,
          Harmonics<Real>,           Translate<Real>, TranslatePairs<Real>};
}

constexpr Kernels MakeKernels(const char* name) { return {name, MakeLoops<float>(), MakeLoops<double>(), InverseRows}; }

}  // namespace
}  // namespace geond::charge
