// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

struct ChargeOptions {
  enum class Solver { kAuto, kDense, kFast };
  Solver solver = Solver::kAuto;
  double tolerance = 5e-4;  // the density differs from the exact discrete solution by at most this, rms relative to its mean
  bool one_sign = false;    // densities that come out negative beside creases are made 0, their neighbours bear them
  int threads = 0;          // 0: all processors; the result does not depend on it
};

// Where the seconds of a solve went.
struct ChargePhases {
  double tree = 0.0;            // and who is near whom
  double near = 0.0;            // integrals between near triangles; of the exact solver all integrals
  double far = 0.0;             // matrices between far cells
  double preconditioner = 0.0;
  double products = 0.0;        // of all the products of the iteration
};

// Equilibrium charge on a conductor of the mesh's shape, for unit total charge, Gaussian units (thesis ch. 4).
struct ChargeDensity {
  std::vector<double> density;     // a triangle, 1/m^2; sum over triangles of density * area = 1
  double potential = 0.0;          // on the surface, 1/m
  double capacitance = 0.0;        // 1 / potential, m: a sphere of radius a has a
  ChargeOptions::Solver solver = ChargeOptions::Solver::kDense;  // the one that was used
  double setup_seconds = 0.0;
  double solve_seconds = 0.0;
  ChargePhases seconds;
  std::size_t negative = 0;        // triangles whose density came out negative (and is, unless options.one_sign)
  std::size_t near_pairs = 0;      // pairs of triangles whose integral is held
  std::size_t peak_bytes = 0;      // of matrices and trees
  double error_estimate = 0.0;     // of the iteration: rms of the density's error relative to its mean; 0: solved exactly
  SolveSummary summary;            // residual: relative, of the potential
};

// Solves V = sum_k rho_k A_ik, sum_k rho_k S_k = 1 (4.11), (4.12), with A_ik the exact integral (A.1) at centroids; the
// capacitance is that of this solution.
// Throws std::invalid_argument, naming the triangle, on a mesh that cannot be solved (no area, duplicate, not finite) and
// Cancelled.
ChargeDensity SolveChargeDensity(const TriangleMesh& mesh, const ChargeOptions& options = {},
                                 std::stop_token stop = {}, const StepObserver& on_step = {});

}  // namespace geond
