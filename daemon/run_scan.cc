// SPDX-License-Identifier: Apache-2.0
#include "daemon/run_scan.h"

#include <numbers>
#include <stdexcept>

#include "calib/make_view.h"

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

}  // namespace

ScanResult RunScan(Station& station, const ScanPlan& plan, const ExposureKeeper& keep, std::stop_token stop,
                   const StepObserver& on_step) {
  if (plan.views < 1) throw std::invalid_argument("RunScan: a scan has at least one view");
  const auto step = [&](std::string_view name, int done, int total) {
    ThrowIfStopped(stop);
    if (on_step) on_step(name, done, total);
  };
  ScanResult result;
  const std::vector<Exposure> exposures = Acquire(station, plan, keep, stop, on_step);
  for (const Exposure& exposure : exposures) {
    step("calibrate", static_cast<int>(result.views.size()), plan.views);
    result.views.push_back(calib::MakeView(exposure, station.geometry(), plan.normals, plan.registering.threads));
  }
  step("register", 0, 0);
  result.registration = calib::RegisterViews(result.views, plan.registering, stop, on_step);

  result.scan.station = station.geometry();
  result.scan.software = GEOND_VERSION;
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    result.views[i].X_TS = result.registration.X_TS[i];
    result.scan.views.push_back({exposures[i], station.geometry().sensor, result.views[i].X_TS_measured,
                                 result.registration.X_TS[i]});
  }
  return result;
}

}  // namespace geond::daemon
