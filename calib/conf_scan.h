// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/range/scan_folder.h"

namespace geond::calib {

// A scan from elsewhere: a .conf file that lists range images as PLY grids (element range_grid, obj_info num_cols and
// num_rows) and the pose of each, as the well-known range scans of the bunny come. Lines `bmesh FILE tx ty tz qx qy qz qw`
// (also `mesh`); the pose takes points of the file, in metres, to the common frame (T here; no table, no axis). The
// quaternion is of the inverse rotation, as those files have it. A missing FILE is looked for as FILE.xz.
//
// Those sensors look along -z of their files with rays that are nearly, but not quite, parallel. The grid's surface is
// therefore sampled again on an exact orthographic grid of the same pitch, linearly within cells without a depth jump; where
// it folds over itself the sheet nearer to the sensor is kept. Throws FileError naming file and line or byte.
RecordedScan ReadConfScan(const std::filesystem::path& path);

}  // namespace geond::calib
