// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace geond {

// How an iterative computation ended. Numbers that do not come out are said here, never thrown and never printed.
struct SolveSummary {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;     // relative, of the quantity the solver drives to zero
  double seconds = 0.0;      // wall time
  std::string message = "not run";
};

}  // namespace geond
