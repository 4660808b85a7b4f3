// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "calib/calibrate.h"

namespace geond::calib {

// A calibration as stored: JSON, format version 1, lengths in mm and angles in degrees by their keys' names. The file is
// written whole or not at all. Both throw FileError, naming the key that is missing or out of range.
void WriteCalibration(const StationCalibration& calibration, const std::filesystem::path& path);
StationCalibration ReadCalibration(const std::filesystem::path& path);

}  // namespace geond::calib
