// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/geon/fit_data.h"
#include "core/geon/refine.h"

namespace geond {

// The least of t1 + lambda gamma t2 over one type: short refinements from every start at `search_lambda` on few points, the
// better half going on, the last ones finished on all points at search_lambda and then at lambda. Of a deformed type the fit
// of its base type, if given, is a start as well, so that the least is hardly ever above the base's. Throws Cancelled.
RefineResult SearchType(GeonType type, const FitData& data, const std::vector<Eigen::Matrix3d>& frames,
                        double search_lambda, double lambda, const GeonState* base, std::stop_token stop);

// From a state near a minimum to that minimum, with the floor of the distances sinking to a share of t1.
RefineResult Polish(const GeonState& start, const FitData& data, double lambda);

// t1 + lambda gamma t2 and the mean depth by which it covers empty places, in the own unit.
double ObjectiveOf(const RefineResult& fit, const FitData& data, double lambda);

ParameterBounds BoundsOf(const FitData& data);

}  // namespace geond
