// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/charge/panels.h"
#include "core/charge/kernels.h"

namespace geond::charge {

// What a solver hands back: the density x for potential 1 everywhere, and what it took.
struct UnitPotentialSolution {
  std::vector<double> x;  // a triangle, 1/m
  double setup_seconds = 0.0;
  double solve_seconds = 0.0;
  std::size_t peak_bytes = 0;
  double error_estimate = 0.0;  // of the iteration: rms of x's error relative to its mean; 0: not estimated
  SolveSummary summary;
};

enum class DenseMethod { kGmres, kLu };

// Solves the whole matrix A_ik of exact integrals (4.16) in double precision: GMRES to a residual of 1e-13, or LU. LU also
// takes over where GMRES does not arrive. Memory 8 N^2 bytes (LU: 16). Throws Cancelled.
UnitPotentialSolution SolveDense(const TriangleMesh& mesh, const Panels& panels, DenseMethod method, int threads,
                                 const std::stop_token& stop, const StepObserver& on_step,
                                 const Kernels& kernels = BestKernels());

}  // namespace geond::charge
