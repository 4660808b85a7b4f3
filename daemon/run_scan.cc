// SPDX-License-Identifier: Apache-2.0
#include "daemon/run_scan.h"

#include <numbers>
#include <stdexcept>

#include "calib/calibration_drift.h"
#include "calib/make_view.h"
#include "calib/table_shift.h"

namespace geond::daemon {
namespace {

// The views that are still to be taken, at equal angles round the table.
std::vector<Exposure> Acquire(Station& station, const ScanPlan& plan, const ExposureKeeper& keep, std::stop_token stop,
                              const StepObserver& on_step) {
  std::vector<Exposure> exposures = plan.taken;
  if (static_cast<int>(exposures.size()) >= plan.views) return exposures;
  const ActiveStation active(station, stop);
  for (int view = static_cast<int>(exposures.size()); view < plan.views; ++view) {
    if (on_step) on_step("acquire", view, plan.views);
    const double angle = plan.first_angle + 2.0 * std::numbers::pi * view / plan.views;
    exposures.push_back(station.Expose(angle, stop));
    if (keep) keep(view, exposures.back());
  }
  if (on_step) on_step("acquire", plan.views, plan.views);
  return exposures;
}

// The exposures as a scan, as the station's calibration corrects them.
RecordedScan Recorded(std::vector<Exposure> exposures, const StationGeometry& station,
                      const std::optional<calib::StationCalibration>& calibration) {
  RecordedScan scan;
  scan.station = station;
  scan.software = GEOND_VERSION;
  for (Exposure& exposure : exposures) {
    const Pose X_TS = SensorInTurntable(station, exposure.table_angle);
    scan.views.push_back({std::move(exposure), station.sensor, X_TS, std::nullopt});
  }
  return calibration ? Corrected(scan, *calibration) : scan;
}

}  // namespace

ScanResult RunScan(Station& station, const ScanPlan& plan, const ExposureKeeper& keep, std::stop_token stop,
                   const StepObserver& on_step) {
  if (plan.views < 1) throw std::invalid_argument("RunScan: a scan has at least one view");
  const auto step = [&](std::string_view name, int done, int total) {
    ThrowIfStopped(stop);
    if (on_step) on_step(name, done, total);
  };
  ScanResult result;
  result.scan = Recorded(Acquire(station, plan, keep, stop, on_step), station.geometry(), plan.calibration);
  for (const RecordedScan::View& view : result.scan.views) {
    step("calibrate", static_cast<int>(result.views.size()), plan.views);
    result.views.push_back(calib::MakeView(view.exposure, result.scan.station, plan.normals, plan.registering.threads));
  }
  step("register", 0, 0);
  result.registration = calib::RegisterViews(result.views, plan.registering, stop, on_step);
  if (plan.calibration) {
    for (auto& note : calib::CalibrationDrift(result.registration, *plan.calibration)) {
      result.registration.notes.push_back(std::move(note));
    }
  }
  for (std::size_t i = 0; i < result.views.size(); ++i) result.views[i].X_TS = result.registration.X_TS[i];
  calib::ShiftOntoTable(result.views);
  for (std::size_t i = 0; i < result.views.size(); ++i) result.scan.views[i].X_TS_refined = result.views[i].X_TS;
  return result;
}

}  // namespace geond::daemon
