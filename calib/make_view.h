// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/table_plane.h"
#include "core/range/range_view.h"
#include "core/range/scan_folder.h"

namespace geond::calib {

// A view from one exposure: the object cut from table and background by the thresholds of the station's work space, with
// normals, at the pose that calibration and table angle give. The whole line's first step on data. Throws
// std::invalid_argument if the image's size is not the sensor's.
RangeView MakeView(const Exposure& exposure, const StationGeometry& station, const NormalOptions& options = {},
                   int threads = 0);

// The views of a recorded scan: poses as recorded (refined where they are).
std::vector<RangeView> MakeViews(const RecordedScan& scan, const NormalOptions& options = {}, int threads = 0);

// The same, and how far each view's own table plane lay from the calibrated one (z = 0 of T), in numbers and words.
struct ViewsOfScan {
  std::vector<RangeView> views;
  std::vector<TablePlane> tables;   // a view, as measured from its own returns
  std::vector<std::string> notes;   // for a person: table off, table not seen, view empty
};
ViewsOfScan MakeViewsAndTables(const RecordedScan& scan, const NormalOptions& options = {}, int threads = 0);

}  // namespace geond::calib
