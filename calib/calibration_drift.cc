// SPDX-License-Identifier: Apache-2.0
#include "calib/calibration_drift.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/printed.h"

namespace geond::calib {
namespace {

constexpr double kDeviations = 4.0;        // beyond so many standard deviations a change is real
constexpr double kTurnThatMatters = 0.0017;   // rad
constexpr double kShiftThatMatters = 0.0002;  // m
constexpr double kWorseThanNoise = 4.0;    // times the deviation of the distance of two noisy views

}  // namespace

std::vector<std::string> CalibrationDrift(const RegistrationResult& registration, const StationCalibration& calibration) {
  std::vector<std::string> words;
  const std::string of = Printed("calibration %d of %s", calibration.number, calibration.date.c_str());
  if (registration.model == RegisterOptions::Model::kTurntable) {
    const auto& found = registration.sensor_correction;
    const auto& covariance = registration.sensor_covariance;
    const double turn = found.head<3>().norm(), shift = found.tail<3>().norm();
    const double turn_sigma = std::hypot(std::sqrt(covariance.topLeftCorner<3, 3>().trace()), calibration.axis_direction_sigma);
    const double shift_sigma =
        std::hypot(std::sqrt(covariance.bottomRightCorner<3, 3>().trace()), calibration.axis_position_sigma);
    if (turn > std::max(kTurnThatMatters, kDeviations * turn_sigma) ||
        shift > std::max(kShiftThatMatters, kDeviations * shift_sigma)) {
      words.push_back(Printed("the sensor stands %.2f deg and %.2f mm from where %s has it against the table's axis (known to "
                              "%.2f deg and %.2f mm here): this scan is corrected for it; calibrate the station again",
                              turn * 180.0 / std::numbers::pi, shift * 1e3, of.c_str(), turn_sigma * 180.0 / std::numbers::pi,
                              shift_sigma * 1e3));
    }
  }
  const double expected = std::numbers::sqrt2 * calibration.station.sensor.depth_noise;
  if (expected > 0.0 && registration.rms_after > kWorseThanNoise * expected) {
    words.push_back(Printed("the views agree to %.2f mm only, where the sensor's noise lets expect %.2f mm: the object moved, "
                            "the table is loose, or %s is out of date", registration.rms_after * 1e3, expected * 1e3,
                            of.c_str()));
  }
  return words;
}

}  // namespace geond::calib
