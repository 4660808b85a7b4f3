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
};

struct GmresResult {
  std::vector<double> x;
  SolveSummary summary;  // residual: |b - A x| / |b| as the recurrence knows it
};

// Solves A x = b by flexible GMRES (Saad 1993), preconditioned from the right by `precondition`, an approximate inverse that
// may round as it likes: the answer is put together from what it gave. The residual is the true one. Calls on_iteration(iteration, residual) after each step. Throws Cancelled.
GmresResult SolveGmres(const LinearMap& A, const LinearMap& precondition, std::span<const double> b,
                       const GmresOptions& options, const std::stop_token& stop = {},
                       const std::function<void(int, double)>& on_iteration = {});

}  // namespace geond::charge
