// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/range/range_view.h"

namespace geond::calib {

// Object pixels in groups of fewer than `least_pixels` that hang together (over sides and corners, without regard to depth)
// become kRejected: returns of the table that noise lifts over the clearance, and lost mixed pixels.
void RejectSpeckles(RangeView& view, int least_pixels = 12);

}  // namespace geond::calib
