// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/geon/fit.h"
#include "core/geon/fit_data.h"
#include "core/geon/refine.h"

namespace geond {

// The least of t1 + lambda gamma t2 over one type: short refinements from every start at options.search_lambda on few
// points, the better half going on, the last ones at options.lambda and on all points. Of a deformed type the fit of its
// base type, if given, is a start as well, so that the least is hardly ever above the base's. Throws Cancelled.
RefineResult SearchType(GeonType type, const FitData& data, const std::vector<Eigen::Matrix3d>& frames,
                        const FitOptions& options, const GeonState* base, std::stop_token stop);

// From a state near a minimum to that minimum, with the floor of the distances sinking to a share of t1, until a step gains
// less than a share `tolerance`.
RefineResult Polish(const GeonState& start, const FitData& data, double lambda, double least_gamma, double tolerance);

// t1 + lambda gamma t2 and the mean depth by which it covers empty places, in the own unit.
double ObjectiveOf(const RefineResult& fit, const FitData& data, double lambda);

}  // namespace geond
