// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/solve_summary.h"
#include "core/range/scan_folder.h"

namespace geond::calib {

// Where things stand at a station and how its sensor errs, as found by measurement: what is stored and used.
struct StationCalibration {
  StationGeometry station;        // corrected: X_WT, focal lengths
  double depth_scale = 1.0;       // true depth = depth_scale * read depth + depth_offset
  double depth_offset = 0.0;      // m
  // Standard deviations of what was found.
  double axis_direction_sigma = 0.0;  // rad
  double axis_position_sigma = 0.0;   // m, of the axis at the table among the points measured there
  double scale_sigma = 0.0;           // of depth_scale
  double check_error = 0.0;           // m: found less true diameter of the check object
  int number = 0;                     // of the station's calibrations, as the caller counts them
  std::string date;                   // as the caller gives it, ISO 8601
  std::string name;                   // of the station, as the caller gives it
};

// Why a calibration is not one of this station, in a sentence: another sensor, or numbers too far from the assumed ones;
// empty if it fits.
std::string Mismatch(const StationCalibration& calibration, const StationGeometry& assumed);

// An exposure as a faultless sensor would have given it: use before MakeView.
Exposure Corrected(const Exposure& exposure, const StationCalibration& calibration);
// The same for a scan: station, sensor models, images and measured poses by the calibration.
RecordedScan Corrected(const RecordedScan& scan, const StationCalibration& calibration);

// Exposures of one sphere lying still on the table while that turns.
struct TargetPlacement {
  double diameter = 0.0;            // m
  std::vector<Exposure> exposures;  // at several table angles
};

struct CalibrateOptions {
  double prior_scale = 0.005;         // standard deviations of the sensor's errors by its data sheet: depth scale and focal
  double prior_offset = 0.002;        // lengths, relative, and depth offset, m
  double max_scale_error = 0.02;      // beyond: rather the diameter was given wrong
  double max_plate_tilt = 0.0087;     // rad of the table top against the axis: beyond, the axis is bent
  double max_departure = 0.00015;     // m, rms of the target's path from a circle about the axis
  double max_check_error = 0.0001;    // m, of the check object's diameter
  double max_direction_sigma = 0.0009;  // rad: the axis is known too badly beyond
  double max_position_sigma = 0.0001;   // m
};

struct CalibrationResult {
  bool accepted = false;
  std::vector<std::string> reasons;  // why not, and what to do; empty if accepted
  std::vector<std::string> notes;    // what was found, for a person
  StationCalibration calibration;    // the fit; to be used only if accepted
  double rms = 0.0;                  // m, of all returns from their sphere
  double departure = 0.0;            // m, rms of single sphere centres from the circle they should move on
  double plate_tilt = 0.0;           // rad
  SolveSummary summary;
};

// Solves jointly (Ceres) for the table's axis and plane in the sensor's frame, the depth scale and offset and the focal
// lengths, from a sphere of known diameter in two or more placements, each seen at four or more table angles; judges the
// result on `check`, a sphere of another known diameter that takes no part in the fit. `assumed` may be wrong by degrees and
// millimetres. What does not come out is said in `reasons`. Throws std::invalid_argument on diameters that are not positive
// or images that do not fit the sensor model, and Cancelled.
CalibrationResult CalibrateStation(const StationGeometry& assumed, const std::vector<TargetPlacement>& target,
                                   const std::vector<TargetPlacement>& check, const CalibrateOptions& options = {},
                                   std::stop_token stop = {}, const StepObserver& on_step = {});

}  // namespace geond::calib
