// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"

namespace geond {

struct ContourOptions {
  enum class Solver { kAuto, kDense, kFast };  // by itself: the whole matrix up to 600 segments
  Solver solver = Solver::kAuto;
  double tolerance = 1e-5;  // the density differs from the exact discrete solution by at most this, rms relative to its mean
  int threads = 0;          // 0: all processors; the result does not depend on it
};

// Equilibrium charge on a closed curve in the plane, for unit total charge (thesis 6.3.1).
struct ContourDensity {
  std::vector<double> density;          // a vertex (a pixel of the outline): the mean of the two segments there, 1/m
  std::vector<double> segment_density;  // segment i runs from vertex i to the next; sum of density * length = 1
  double potential = 0.0;               // -2 sum of the integrals of density * ln(distance in m)
  double error_estimate = 0.0;          // of the solver: rms of the segments' charges relative to their mean; 0: exact solve
  SolveSummary summary;
};

// Solves V = -2 sum_k rho_k (integral over segment k of ln|r_i - r'| ds'), sum_k rho_k length_k = 1, at the middles r_i of
// the segments, V unknown; the integrals are exact. By LU of the whole matrix, or by multipoles in time and memory
// proportional to the segments. The polygon is closed by itself, either way round; a last vertex that repeats the first is
// dropped. Throws std::invalid_argument, naming the vertex, on fewer than three vertices, one that is not finite or one that
// repeats the one before it; Cancelled.
ContourDensity SolveContourCharge(std::span<const Eigen::Vector2d> polygon, const ContourOptions& options = {},
                                  std::stop_token stop = {}, const StepObserver& on_step = {});

}  // namespace geond
