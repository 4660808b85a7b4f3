// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geon/misfit.h"

namespace geond {

// What bounds the parameters, in the unit of the points (Table 5.2 as corrected: room for strong bends).
struct ParameterBounds {
  double least_size = 1e-3, greatest_size = 1.0;
  double least_gamma = 0.1;                           // of the mean half size, gamma of (5.18)
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   // of the data
  double reach = 0.75;                                // the geon's centre lies within this of it along each axis
};

struct RefineOptions {
  double lambda = 5.0;
  double floor = 1e-3;          // below this |e| counts by its square (MisfitSums::smooth), so that there is a slope
  int iterations = 50;          // trial steps, accepted or not
  double tolerance = 1e-10;     // ends when E would fall by less than this share, or steps are shorter than this
  double damping = 1e-3;        // to begin with
};

struct RefineResult {
  GeonState state;
  double objective = 0.0;       // smooth t1 + lambda gamma t2
  double t1 = 0.0, t2 = 0.0;
  int evaluations = 0;          // of the objective, over all points
  bool converged = false;
};

// The state pushed back into its bounds.
GeonState Bounded(const GeonState& state, const ParameterBounds& bounds);
// The state moved by a step: turned by exp(w) on the right, moved along G's axes, the rest added; then bounded.
GeonState Stepped(const GeonState& state, const ParameterVector& step, const ParameterBounds& bounds);

// Levenberg and Marquardt on t1 + lambda gamma t2 from `start`, with steps along the bounds where they hold it back. The
// distances count through weights 1/|e|, which make a sum of magnitudes one of squares.
RefineResult Refine(const GeonState& start, const LanePoints& points, const ParameterBounds& bounds,
                    const RefineOptions& options);

}  // namespace geond
