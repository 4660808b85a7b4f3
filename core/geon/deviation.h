// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geon/ends.h"
#include "core/geon/fit_data.h"
#include "core/geon/misfit.h"

namespace geond {

// Standard deviations of the parameters of `state`, fitted to `data` at `lambda`, in the own unit: position along G's axes 3,
// rotation about G's axes 3, size 3, taper 2, bend 1 (0 for those the type has not). From the slopes of stretches of eight
// neighbouring points, whose errors are taken as related (plane fits share points), and the expected curvature. Across an axis
// with a bounded end the room between points and empty places is added; with a hidden end they are infinite (of a round side:
// four times as large), and so where a figure would exceed what it is of.
std::vector<double> Deviations(const GeonState& state, const FitData& data, double lambda, const Ends& ends);

}  // namespace geond
