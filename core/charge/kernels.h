// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/charge/triangle_frame.h"

namespace geond::charge {

// The inner loops, compiled once for each instruction set and chosen when the program runs.
struct Kernels {
  const char* name;

  // out[i] = integral over the triangle of dS'/|r_i - r'| at n points r_i = (x[i], y[i], z[i]). The same bits from every
  // instruction set.
  void (*triangle_potential)(const TriangleFrame& triangle, const double* x, const double* y, const double* z, int n,
                             double* out);

  // y += A x for a column-major block of `rows` by `columns` whose columns lie `stride` apart.
  void (*multiply_double)(const double* A, int rows, int columns, int stride, const double* x, double* y);
};

// The best that this machine can run, and all that it can run (the plainest first).
const Kernels& BestKernels();
std::span<const Kernels* const> UsableKernels();

}  // namespace geond::charge
