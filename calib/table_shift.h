// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/range/range_view.h"

namespace geond::calib {

// Shifts the refined poses (X_TS) along the table's axis so that the table top, as all views together saw it, lies at z = 0 of T
// where the axis meets it. Returns by how much they were raised, m; 0 if too little of the table was seen.
double ShiftOntoTable(std::vector<RangeView>& views);

}  // namespace geond::calib
