// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrate.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "calib/path_check.h"
#include "core/base/printed.h"
#include "calib/station_fit.h"

namespace geond::calib {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kFewestAngles = 4;
// Beyond these a calibration and the assumed station are of two different set-ups.
constexpr double kOtherSensor = 0.03, kOtherTurn = 5.0 * kDegree, kOtherShift = 0.020;
constexpr double kLeastSpan = 120.0 * kDegree;  // that the angles of a placement must cover

void Validate(const StationGeometry& assumed, const std::vector<TargetPlacement>& placements) {
  for (const auto& placement : placements) {
    if (!(placement.diameter > 0.0) || !std::isfinite(placement.diameter)) {
      throw std::invalid_argument("CalibrateStation: a diameter is not positive");
    }
    for (const auto& exposure : placement.exposures) {
      if (exposure.image.columns != assumed.sensor.columns || exposure.image.rows != assumed.sensor.rows ||
          exposure.image.depth.size() != static_cast<std::size_t>(assumed.sensor.columns) * assumed.sensor.rows) {
        throw std::invalid_argument("CalibrateStation: an image has not the size of the sensor model");
      }
    }
  }
}

// Greatest angle of the table minus the widest gap between neighbours, that is what the angles cover.
double Span(const std::vector<TargetSighting>& sightings) {
  std::vector<double> angles;
  for (const auto& sighting : sightings) {
    const double turn = std::fmod(sighting.table_angle, 2.0 * std::numbers::pi);
    angles.push_back(turn < 0 ? turn + 2.0 * std::numbers::pi : turn);
  }
  if (angles.empty()) return 0.0;
  std::sort(angles.begin(), angles.end());
  double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t k = 1; k < angles.size(); ++k) gap = std::max(gap, angles[k] - angles[k - 1]);
  return 2.0 * std::numbers::pi - gap;
}

std::vector<SightedPlacement> Sight(const StationGeometry& assumed, const std::vector<TargetPlacement>& placements,
                                    const std::stop_token& stop, const std::function<void()>& on_exposure) {
  std::vector<SightedPlacement> sighted;
  for (const auto& placement : placements) {
    SightedPlacement seen;
    seen.radius = 0.5 * placement.diameter;
    for (const auto& exposure : placement.exposures) {
      ThrowIfStopped(stop);
      if (auto sighting = FindTarget(exposure, assumed, seen.radius)) seen.sightings.push_back(std::move(*sighting));
      on_exposure();
    }
    sighted.push_back(std::move(seen));
  }
  return sighted;
}

void JudgeSightings(const std::vector<TargetPlacement>& target, const std::vector<SightedPlacement>& sighted,
                    std::vector<std::string>& reasons) {
  if (target.size() < 2) {
    reasons.push_back("one placement of the target does not show axis and sensor apart: put it in two or three places, "
                      "near and far from the axis");
  }
  for (std::size_t k = 0; k < sighted.size(); ++k) {
    const std::size_t seen = sighted[k].sightings.size(), taken = target[k].exposures.size();
    if (seen < static_cast<std::size_t>(kFewestAngles)) {
      reasons.push_back(Printed("placement %zu: a sphere of %.2f mm was found in %zu of %zu images, %d are needed: check the "
                                "diameter (not the radius), and that nothing else stands on the table",
                                k + 1, 2e3 * sighted[k].radius, seen, taken, kFewestAngles));
    } else if (Span(sighted[k].sightings) < kLeastSpan) {
      reasons.push_back(Printed("placement %zu: its table angles cover %.0f degrees, %.0f are needed: turn the table further",
                                k + 1, Span(sighted[k].sightings) / kDegree, kLeastSpan / kDegree));
    }
  }
}

StationCalibration CalibrationOf(const StationGeometry& assumed, const StationFit& fit) {
  StationCalibration found;
  found.station = assumed;
  found.station.X_WT = assumed.X_WS * fit.X_ST;
  found.station.sensor.focal_u *= 1.0 + fit.sensor[2];
  found.station.sensor.focal_v *= 1.0 + fit.sensor[3];
  found.depth_scale = 1.0 + fit.sensor[0];
  found.depth_offset = fit.sensor[1];
  found.axis_direction_sigma = fit.axis_direction_sigma;
  found.axis_position_sigma = fit.axis_position_sigma;
  found.scale_sigma = fit.scale_sigma;
  return found;
}

void JudgeFit(const StationFit& fit, const CalibrateOptions& options, CalibrationResult& result) {
  const double scale = std::max({std::abs(fit.sensor[0]), std::abs(fit.sensor[2]), std::abs(fit.sensor[3])});
  auto& reasons = result.reasons;
  if (!fit.known || fit.axis_direction_sigma > options.max_direction_sigma ||
      fit.axis_position_sigma > options.max_position_sigma) {
    reasons.push_back(Printed("the axis is known to %.3f deg and %.3f mm only (%.3f and %.3f are needed): add a placement far "
                              "from the axis, and another at another height",
                              fit.axis_direction_sigma / kDegree, fit.axis_position_sigma * 1e3,
                              options.max_direction_sigma / kDegree, options.max_position_sigma * 1e3));
  }
  if (scale > options.max_scale_error) {
    reasons.push_back(Printed("the sensor would have to be wrong by %.1f %%: rather the target's diameter was given wrong; "
                              "measure it again", scale * 100.0));
  }
  if (result.plate_tilt > options.max_plate_tilt) {
    reasons.push_back(Printed("the table top is tilted %.2f deg against the axis it turns about: the axis is bent or the top "
                              "sits crooked; mend that first", result.plate_tilt / kDegree));
  }
  if (!fit.summary.converged) reasons.push_back("the solve did not end: " + fit.summary.message);
}

// Diameter of the check sphere by the calibrated station, over all its images.
void JudgeCheck(const StationGeometry& assumed, const StationFit& fit, const std::vector<TargetPlacement>& check,
                const std::vector<SightedPlacement>& sighted, const CalibrateOptions& options,
                CalibrationResult& result) {
  if (check.empty()) {
    result.reasons.push_back("no check object: scan a sphere of another known diameter, which the fit does not use");
    return;
  }
  for (std::size_t k = 0; k < sighted.size(); ++k) {
    std::vector<Eigen::Vector3d> points_T;
    for (const auto& sighting : sighted[k].sightings) {
      const Pose X_TS = Inverse(fit.X_ST * Pose::Rotation(Eigen::Vector3d::UnitZ(), sighting.table_angle));
      for (const auto& raw : sighting.sphere) points_T.push_back(X_TS * CorrectedPoint(assumed.sensor, fit.sensor, raw));
    }
    if (sighted[k].sightings.size() < 2) {
      result.reasons.push_back(Printed("check object %zu: a sphere of %.2f mm was found in %zu images, two are needed", k + 1,
                                       check[k].diameter * 1e3, sighted[k].sightings.size()));
      continue;
    }
    Eigen::Vector3d start = Eigen::Vector3d::Zero();
    for (const auto& p : points_T) start += p / static_cast<double>(points_T.size());
    const double found = 2.0 * FitSphere(points_T, start, 0.0).radius, error = found - check[k].diameter;
    if (std::abs(error) > std::abs(result.calibration.check_error)) result.calibration.check_error = error;
    result.notes.push_back(Printed("check object %zu: diameter %.3f mm, %+.3f mm from the true one", k + 1, found * 1e3,
                                   error * 1e3));
    if (std::abs(error) > options.max_check_error) {
      const bool good_fit = result.departure <= options.max_departure && result.plate_tilt <= options.max_plate_tilt;
      result.reasons.push_back(
          good_fit ? Printed("the check object comes out %+.3f mm off (%.3f allowed) while the target itself fits well: one of "
                             "the two diameters was given wrong (the target would be %.3f times as large)",
                             error * 1e3, options.max_check_error * 1e3, check[k].diameter / found)
                   : Printed("the check object comes out %+.3f mm off (%.3f allowed)", error * 1e3,
                             options.max_check_error * 1e3));
    }
  }
}

}  // namespace

std::string Mismatch(const StationCalibration& calibration, const StationGeometry& assumed) {
  const SensorModel &found = calibration.station.sensor, &sensor = assumed.sensor;
  if (found.columns != sensor.columns || found.rows != sensor.rows || found.projection != sensor.projection) {
    return Printed("it is of a sensor with %d x %d pixels, this one has %d x %d", found.columns, found.rows, sensor.columns,
                   sensor.rows);
  }
  const double focal = std::max(std::abs(found.focal_u / sensor.focal_u - 1.0), std::abs(found.focal_v / sensor.focal_v - 1.0));
  if (focal > kOtherSensor || found.center_u != sensor.center_u || found.center_v != sensor.center_v) {
    return Printed("its sensor model is another one (focal lengths differ by %.1f %%)", focal * 100.0);
  }
  const Pose moved = Inverse(Inverse(assumed.X_WS) * assumed.X_WT) *
                     (Inverse(calibration.station.X_WS) * calibration.station.X_WT);
  const double turn = moved.rotation().angularDistance(Eigen::Quaterniond::Identity()), shift = moved.translation().norm();
  if (turn > kOtherTurn || shift > kOtherShift) {
    return Printed("its table stands %.1f deg and %.1f mm from where the configuration has it: one of the two is of another "
                   "set-up", turn / kDegree, shift * 1e3);
  }
  return {};
}

Exposure Corrected(const Exposure& exposure, const StationCalibration& calibration) {
  Exposure corrected = exposure;
  for (float& depth : corrected.image.depth) {
    depth = static_cast<float>(calibration.depth_scale * depth + calibration.depth_offset);
  }
  return corrected;
}

RecordedScan Corrected(const RecordedScan& scan, const StationCalibration& calibration) {
  RecordedScan corrected = scan;
  corrected.station = calibration.station;
  corrected.calibration = {calibration.number, calibration.name, calibration.date, calibration.depth_scale,
                           calibration.depth_offset};
  for (auto& view : corrected.views) {
    view.exposure = Corrected(view.exposure, calibration);
    view.sensor = calibration.station.sensor;
    view.X_TS_measured = SensorInTurntable(calibration.station, view.exposure.table_angle);
    view.X_TS_refined.reset();
  }
  return corrected;
}

CalibrationResult CalibrateStation(const StationGeometry& assumed, const std::vector<TargetPlacement>& target,
                                   const std::vector<TargetPlacement>& check, const CalibrateOptions& options,
                                   std::stop_token stop, const StepObserver& on_step) {
  Validate(assumed, target);
  Validate(assumed, check);
  int total = 0, done = 0;
  for (const auto* placements : {&target, &check}) {
    for (const auto& placement : *placements) total += static_cast<int>(placement.exposures.size());
  }
  const auto on_exposure = [&] {
    if (on_step) on_step("calibrate", ++done, total);
  };
  CalibrationResult result;
  result.calibration.station = assumed;
  const auto sighted = Sight(assumed, target, stop, on_exposure), checked = Sight(assumed, check, stop, on_exposure);
  JudgeSightings(target, sighted, result.reasons);
  if (!result.reasons.empty()) return result;

  ThrowIfStopped(stop);
  const StationFit fit = SolveStation(assumed.sensor, Inverse(assumed.X_WS) * assumed.X_WT, sighted, options);
  result.summary = fit.summary;
  result.rms = fit.rms;
  result.plate_tilt = std::atan(std::hypot(fit.plate[0], fit.plate[1]));
  result.calibration = CalibrationOf(assumed, fit);
  const PathCheck path = CheckPaths(assumed.sensor, fit, sighted);
  result.departure = path.rms;
  JudgeFit(fit, options, result);
  if (path.rms > options.max_departure) result.reasons.push_back(path.reason);

  const Pose moved = Inverse(assumed.X_WT) * result.calibration.station.X_WT;
  const Eigen::Vector3d axis = moved.Rotate(Eigen::Vector3d::UnitZ());
  result.notes.push_back(Printed("axis: %.3f deg and (%+.3f, %+.3f) mm from where it was assumed, table %+.3f mm; known to "
                                 "%.3f deg and %.3f mm",
                                 std::acos(std::clamp(axis.z(), -1.0, 1.0)) / kDegree, moved.translation().x() * 1e3,
                                 moved.translation().y() * 1e3, moved.translation().z() * 1e3,
                                 fit.axis_direction_sigma / kDegree, fit.axis_position_sigma * 1e3));
  result.notes.push_back(Printed("sensor: depth %+.3f %% %+.3f mm, focal lengths %+.3f %% and %+.3f %%",
                                 fit.sensor[0] * 100, fit.sensor[1] * 1e3, fit.sensor[2] * 100, fit.sensor[3] * 100));
  result.notes.push_back(Printed("target: returns %.3f mm rms from the sphere, its centres %.3f mm rms from their circles",
                                 fit.rms * 1e3, path.rms * 1e3));
  JudgeCheck(assumed, fit, check, checked, options, result);
  result.accepted = result.reasons.empty();
  return result;
}

}  // namespace geond::calib
