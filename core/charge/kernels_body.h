// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>

#include "core/charge/kernels.h"
#include "core/charge/kernels_inverse.h"
#include "core/charge/kernels_loops.h"
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

constexpr Kernels MakeKernels(const char* name) {
  return {name, TrianglePotentialAt, MakeLoops<float>(), MakeLoops<double>(), InverseRows};
}

}  // namespace
}  // namespace geond::charge
