// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <nlohmann/json.hpp>

#include "core/geon/fit.h"

namespace geond {

// A number, or null for one that is not finite, which has no form in JSON.
nlohmann::ordered_json FiniteOrNull(double value);
// Standard deviations of a fit's parameters, lengths in mm; null where the data do not say.
nlohmann::ordered_json DeviationToJson(const GeonFit& fit);
// What is known of the ends across -x +x, -y +y, -z +z: "seen", "bounded" or "hidden".
nlohmann::ordered_json EndsToJson(const GeonFit& fit);

// The axes across which a flat end is hidden: the size along them is what was seen of it, the shape may go on. (The
// width of a round side is told by its curvature.)
std::array<bool, 3> SizesAtLeast(const GeonFit& fit);

}  // namespace geond
