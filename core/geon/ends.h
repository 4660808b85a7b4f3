// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "core/geon/fit.h"
#include "core/geon/fit_data.h"
#include "core/geon/misfit.h"

namespace geond {

struct Ends {
  EndStates state{};
  std::array<std::array<double, 2>, 3> reach{};  // how far the points go along the axis, from the centre, own unit
  std::array<std::array<double, 2>, 3> gap{};    // from the end of the geon to the first empty places; infinite if none
};
Ends JudgeEnds(const GeonState& state, const FitData& data);

// The geon without what nobody saw: flat ends that are hidden move back to where the points (or the cut) end. Round
// sides stay, their curvature tells their width; so do the sides of tapered shapes, which would not keep their form.
GeonState WithoutHiddenLength(const GeonState& state, const FitData& data);

}  // namespace geond
