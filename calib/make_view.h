// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/range/range_view.h"
#include "core/range/scan_folder.h"

namespace geond::calib {

// A view from one exposure: the object cut from table and background by the thresholds of the station's work space, with
// normals, at the pose that calibration and table angle give. The whole line's first step on data.
RangeView MakeView(const Exposure& exposure, const StationGeometry& station, const NormalOptions& options = {},
                   int threads = 0);

// The views of a recorded scan: poses as recorded (refined where they are).
std::vector<RangeView> MakeViews(const RecordedScan& scan, const NormalOptions& options = {}, int threads = 0);

}  // namespace geond::calib
