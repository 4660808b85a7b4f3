// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "calib/calibrate.h"
#include "calib/register_views.h"
#include "core/base/progress.h"
#include "core/range/range_view.h"
#include "core/range/scan_folder.h"
#include "daemon/station.h"

namespace geond::daemon {

struct ScanPlan {
  int views = 8;                    // evenly round the table, >= 1
  double first_angle = 0.0;         // rad
  std::vector<Exposure> taken;      // of an earlier run that was cut short: the first views, not taken again
  calib::RegisterOptions registering;
  NormalOptions normals;
  std::optional<calib::StationCalibration> calibration;  // absent: the station as configured
};

// Told of each exposure as it is taken, on the device thread, before the next one begins: puts it where it is safe. What it
// throws ends the scan.
using ExposureKeeper = std::function<void(int view, const Exposure& exposure)>;

struct ScanResult {
  RecordedScan scan;                // with refined poses; images as the calibration corrects them
  std::vector<RangeView> views;     // registered
  calib::RegistrationResult registration;
};

// The first half of the line, on the device thread: acquire, calibrate, register. The laser shines and the motor is on only
// while views are acquired. Throws DeviceError, Cancelled, what `keep` throws, std::invalid_argument for an impossible plan.
ScanResult RunScan(Station& station, const ScanPlan& plan, const ExposureKeeper& keep = {}, std::stop_token stop = {},
                   const StepObserver& on_step = {});

}  // namespace geond::daemon
