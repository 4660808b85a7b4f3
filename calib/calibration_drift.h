// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "calib/register_views.h"

namespace geond::calib {

// What the registration of an ordinary scan says against the calibration it was made with, a sentence each: the sensor no
// longer stands where it did against the table's axis (beyond what scan and calibration can tell, and beyond what matters),
// or the views agree much worse than the sensor's noise lets expect. Empty if nothing is wrong.
std::vector<std::string> CalibrationDrift(const RegistrationResult& registration, const StationCalibration& calibration);

}  // namespace geond::calib
