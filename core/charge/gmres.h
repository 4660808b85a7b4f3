// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/solve_summary.h"

namespace geond::charge {

// y = A x for one vector; x and y never overlap.
using LinearMap = std::function<void(std::span<const double> x, std::span<double> y)>;

struct GmresOptions {
  double tolerance = 1e-6;   // on |b - A x| / |b|
  int max_iterations = 200;  // of the whole, none restarted
  int threads = 0;           // the result does not depend on it

  // With weights (positive, of sum 1) the iteration ends as soon as the error is estimated at no more than
  // `error_tolerance`, though the residual be above its tolerance. What is then known of the error is taken off: M
  // times the last residual, which costs no product with A.
  std::span<const double> weights = {};
  double error_tolerance = 0.0;
};

struct GmresResult {
  std::vector<double> x;
  SolveSummary summary;  // residual: |b - A x| / |b| as the recurrence knows it
  // With weights: of the root of the weighted mean square of x's error, over the mean of x; from |M (b - A x)|, the
  // last correction, and how fast the corrections fell.
  double error_estimate = 0.0;
};

// Solves A x = b by flexible GMRES (Saad 1993), preconditioned from the right by M, `precondition`, an approximate
// inverse that may round as it likes: the answer is put together from what it gave. The residual is the true one. As M
// is close to the inverse of A, M (b - A x) is close to the error of x. Calls on_iteration(iteration, residual) after
// each step. Throws Cancelled.
GmresResult SolveGmres(const LinearMap& A, const LinearMap& precondition, std::span<const double> b,
                       const GmresOptions& options, const std::stop_token& stop = {},
                       const std::function<void(int, double)>& on_iteration = {});

}  // namespace geond::charge
