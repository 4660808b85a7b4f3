// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/range/range_view.h"

namespace geond::calib {

// Object pixels that mix the light of two surfaces become kRejected: those beside a depth jump that leave the surface on
// their own side of it (line through the two pixels further from the jump), and those with a jump on both sides. A jump is
// a step in depth between neighbours that a surface at `max_incidence` (rad) would not make.
void RejectMixedPixels(RangeView& view, double max_incidence);

}  // namespace geond::calib
