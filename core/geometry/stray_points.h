// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/geometry/point_cloud.h"

namespace geond {

// The cloud without its stray points: those in groups that lie apart from the rest (by some three spacings of the
// points or more) and hold less than `least_share` of the largest group. If that would take more than a tenth of the
// cloud, it is sparse rather than strewn and stays whole. `notes` (or null) is told how many points went.
PointCloud WithoutStrayPoints(const PointCloud& cloud, double least_share = 0.02,
                              std::vector<std::string>* notes = nullptr);

}  // namespace geond
