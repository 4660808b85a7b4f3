// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/charge/dense.h"
#include "core/charge/far_field.h"
#include "core/charge/interactions.h"
#include "core/charge/kernels.h"
#include "core/charge/near_field.h"
#include "core/charge/panels.h"

namespace geond::charge {

// How finely the fast solver computes. FastSettingsFor picks them for a tolerance; tests and benchmarks may set their
// own.
struct FastSettings {
  bool double_precision = false;
  OrderRule order;  // of the multipoles
  FarRule far;
  int leaf_capacity = 32;  // triangles
  NearRule near;
  int halo = 32;               // triangles around a leaf in the preconditioner's local solve
  int coarse_triangles = 500;  // most in a cell of its coarse level
  double error = 5e-4;         // of the density, estimated, rms relative to its mean, at which the iteration ends
  double residual = 1e-9;      // relative, of the potential, at which it ends in any case
};

constexpr double kLeastFastTolerance = 1e-6;

// Settings under which the density differs from that of the exact matrix by at most `tolerance` rms.
FastSettings FastSettingsFor(double tolerance, std::size_t triangles);

// What the fast solver did, beside the solution.
struct FastReport {
  std::size_t cells = 0, leaves = 0, near_pairs = 0, exact_pairs = 0, far_pairs = 0, matrices = 0;
  std::ptrdiff_t far_multiplications = 0;  // of one product's step across
  std::size_t near_bytes = 0, far_bytes = 0, preconditioner_bytes = 0;
  double tree_seconds = 0.0, near_seconds = 0.0, far_seconds = 0.0, preconditioner_seconds = 0.0;
  double product_seconds = 0.0;  // of all the products in the iteration
};

// Solves the same equations as SolveDense, in time and memory proportional to the triangles: an octree, exact or
// quadrature integrals between near triangles, multipoles between far cells, GMRES with local inverses as
// preconditioner. Throws Cancelled.
UnitPotentialSolution SolveFast(const TriangleMesh& mesh, const Panels& panels, const FastSettings& settings,
                                int threads, const std::stop_token& stop, const StepObserver& on_step,
                                FastReport* report = nullptr, const Kernels& kernels = BestKernels());

}  // namespace geond::charge
