// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <numbers>

#include "calib/target_sphere.h"
#include "core/base/error.h"
#include "daemon/service.h"

namespace geond::daemon {
namespace {

using Code = RpcError::Code;

constexpr int kSightingsNeeded = 4;  // images of a placement that must show the sphere
constexpr double kDegrees = 180.0 / std::numbers::pi;

Json CalibrationJson(const StoredCalibration& stored, int current) {
  return {{"calibration", stored.number},
          {"date", stored.date},
          {"target_mm", stored.target_diameter * 1e3},
          {"check_mm", stored.check_diameter * 1e3},
          {"targets", stored.targets},
          {"checks", stored.checks},
          {"solved", stored.solved},
          {"accepted", stored.accepted},
          {"in_force", stored.number == current},
          {"check_error_mm", stored.solved ? Json(stored.check_error * 1e3) : Json()},
          {"reasons", stored.reasons},
          {"notes", stored.notes}};
}

}  // namespace

StationGeometry Service::Geometry() const { return calibration_ ? calibration_->station : station_->geometry(); }

void Service::LoadCalibration() {
  calibration_.reset();
  calibration_problem_.clear();
  const int number = calibrations_.Current();
  if (number == 0) return;
  try {
    calib::StationCalibration found = calibrations_.Read(number);
    const std::string mismatch = calib::Mismatch(found, station_->geometry());
    if (mismatch.empty()) {
      // Thresholds are no matter of measurement: they are as configured now.
      const StationGeometry configured = station_->geometry();
      found.station.object_radius = configured.object_radius;
      found.station.object_height = configured.object_height;
      found.station.table_clearance = configured.table_clearance;
      calibration_ = std::move(found);
      spdlog::info("calibration {} of {} is in force", number, calibration_->date);
      return;
    }
    calibration_problem_ = "calibration " + std::to_string(number) + " is not used: " + mismatch;
  } catch (const FileError& error) {
    calibration_problem_ = "calibration " + std::to_string(number) + " is not used: " + error.what();
  }
  spdlog::error("{}; calibrate the station again (geon calibrate)", calibration_problem_);
}

Json Service::CalibrationStatus() const {
  if (!calibration_) return {{"calibration", 0}, {"date", ""}, {"problem", calibration_problem_}};
  return {{"calibration", calibration_->number},
          {"date", calibration_->date},
          {"check_error_mm", calibration_->check_error * 1e3},
          {"axis_direction_sigma_deg", calibration_->axis_direction_sigma * kDegrees},
          {"axis_position_sigma_mm", calibration_->axis_position_sigma * 1e3},
          {"depth_scale", calibration_->depth_scale},
          {"depth_offset_mm", calibration_->depth_offset * 1e3},
          {"problem", calibration_problem_}};
}

void Service::PlaceCalibrationTarget(int number, bool check, int views, const Reply& reply) {
  RefuseIfUnsafe();
  const StoredCalibration begun = calibrations_.Summary(number);
  const double diameter = check ? begun.check_diameter : begun.target_diameter;
  auto answer = std::make_shared<Json>();
  RunOnDevice(
      State::kAcquiring,
      [this, number, check, views, diameter, answer](std::stop_token stop) {
        const auto on_step = [&](std::string_view step, int done, int total) {
          device_thread_.Tick();
          OnIo([this, number, name = std::string(step), done, total] {
            Publish("progress", {{"calibration", number}, {"step", name}, {"done", done}, {"total", total}});
          });
        };
        RecordedScan scan;
        scan.station = station_->geometry();
        scan.software = GEOND_VERSION;
        int found = 0;
        {
          const ActiveStation active(*station_, stop);
          for (int view = 0; view < views; ++view) {
            on_step("acquire", view, views);
            Exposure exposure = station_->Expose(2.0 * std::numbers::pi * view / views, stop);
            if (calib::FindTarget(exposure, scan.station, 0.5 * diameter)) ++found;
            const Pose X_TS = SensorInTurntable(scan.station, exposure.table_angle);
            scan.views.push_back({std::move(exposure), scan.station.sensor, X_TS, std::nullopt});
          }
        }
        on_step("acquire", views, views);
        const bool kept = found >= kSightingsNeeded;
        *answer = {{"calibration", number}, {"check", check}, {"views", views}, {"found", found}, {"kept", kept}};
        (*answer)["placement"] = kept ? Json(calibrations_.KeepPlacement(number, check, scan)) : Json();
        (*answer)["remedy"] = kept ? "" : "Check its diameter, see that the sphere is matt and in the sensor's field all "
                                          "the way round, that nothing else stands on the table, and place it again";
      },
      [answer, reply](daemon::Answer status) {
        reply(std::holds_alternative<RpcError>(status) ? std::move(status) : daemon::Answer(*answer));
      });
}

void Service::SolveCalibration(int number, const Reply& reply) {
  RefuseIfBusy();
  calibrations_.Summary(number);
  device_stop_ = {};
  Enter(State::kModelling);
  compute_thread_.Post([this, number, reply, stop = device_stop_.get_token(), assumed = station_->geometry()] {
    std::exception_ptr failure;
    try {
      calib::CalibrationResult result = calib::CalibrateStation(
          assumed, calibrations_.Placements(number, false), calibrations_.Placements(number, true), {}, stop,
          [&](std::string_view step, int done, int total) {
            compute_thread_.Tick();
            OnIo([this, number, name = std::string(step), done, total] {
              Publish("progress", {{"calibration", number}, {"step", name}, {"done", done}, {"total", total}});
            });
          });
      result.calibration.number = number;
      result.calibration.date = DateNow();
      result.calibration.name = station_->devices().front().model + " " + station_->devices().front().serial;
      calibrations_.KeepResult(number, result);
    } catch (...) {
      failure = std::current_exception();
    }
    OnIo([this, number, reply, failure] {
      Enter(State::kIdle);
      try {
        if (failure) std::rethrow_exception(failure);
        if (calibrations_.Summary(number).accepted) {
          calibrations_.Use(number);
          LoadCalibration();
        }
        reply(CalibrationJson(calibrations_.Summary(number), calibrations_.Current()));
      } catch (...) {
        reply(ToRpcError(std::current_exception()));
      }
    });
  });
}

void Service::AddCalibrationMethods() {
  const RpcParameter which = {"calibration", "integer", "Number of the calibration", true, 1, 1e9, {}};
  const auto schema = [](std::initializer_list<std::pair<const char*, const char*>> properties) {
    Json result = {{"type", "object"}, {"properties", Json::object()}};
    for (const auto& [name, type] : properties) result["properties"][name] = {{"type", type}};
    return result;
  };
  const Json one = schema({{"calibration", "integer"}, {"date", "string"}, {"target_mm", "number"}, {"check_mm", "number"},
                           {"targets", "integer"}, {"checks", "integer"}, {"solved", "boolean"}, {"accepted", "boolean"},
                           {"in_force", "boolean"}, {"check_error_mm", "number"}, {"reasons", "array"}, {"notes", "array"}});
  const Json in_force = schema({{"calibration", "integer"}, {"date", "string"}, {"check_error_mm", "number"},
                                {"axis_direction_sigma_deg", "number"}, {"axis_position_sigma_mm", "number"},
                                {"depth_scale", "number"}, {"depth_offset_mm", "number"}, {"problem", "string"}});
  methods_.Add({"calibration.show", Role::kRead, {}, in_force,
                "The calibration in force; number 0 if the station is used as configured.",
                [this](const Json&, Client&, const Reply& reply) { reply(CalibrationStatus()); }});
  methods_.Add({"calibration.list", Role::kRead, {}, schema({{"calibrations", "array"}}), "All calibrations, oldest first.",
                [this](const Json&, Client&, const Reply& reply) {
                  Json list = Json::array();
                  for (const auto& stored : calibrations_.List()) {
                    list.push_back(CalibrationJson(stored, calibrations_.Current()));
                  }
                  reply(Json{{"calibrations", std::move(list)}});
                }});
  methods_.Add({"calibration.begin", Role::kScan,
                {{"target_mm", "number", "Diameter of the target sphere", true, 5, 500, {}},
                 {"check_mm", "number", "Diameter of the check sphere, which the fit does not use", true, 5, 500, {}}},
                one, "Begin a calibration; then place target (two to four times) and check sphere, and solve.",
                [this](const Json& params, Client&, const Reply& reply) {
                  const int number = calibrations_.Begin(1e-3 * params["target_mm"].get<double>(),
                                                         1e-3 * params["check_mm"].get<double>(), DateNow());
                  reply(CalibrationJson(calibrations_.Summary(number), calibrations_.Current()));
                }});
  methods_.Add({"calibration.place", Role::kScan,
                {which,
                 {"check", "boolean", "The check sphere stands on the table, not the target", false, 0, 0, {}},
                 {"views", "integer", "Range images, evenly round the table", false, 4, 72, {}}},
                schema({{"calibration", "integer"}, {"check", "boolean"}, {"views", "integer"}, {"found", "integer"},
                        {"kept", "boolean"}, {"placement", "integer"}, {"remedy", "string"}}),
                "Scan the sphere where it stands now; says in how many images it was found, and keeps them if enough.",
                [this](const Json& params, Client&, const Reply& reply) {
                  PlaceCalibrationTarget(params["calibration"].get<int>(), params.value("check", false),
                                         params.value("views", 8), reply);
                }});
  methods_.Add({"calibration.solve", Role::kScan, {which}, one,
                "Solve, judge on the check sphere, and use what is found if it is accepted.",
                [this](const Json& params, Client&, const Reply& reply) {
                  SolveCalibration(params["calibration"].get<int>(), reply);
                }});
  methods_.Add({"calibration.use", Role::kAdmin,
                {{"calibration", "integer", "Number of an accepted one; 0: the station as configured", true, 0, 1e9, {}}},
                in_force, "Go back to an earlier calibration.", [this](const Json& params, Client&, const Reply& reply) {
                  RefuseIfBusy();
                  const int number = params["calibration"].get<int>();
                  if (number > 0 && !calibrations_.Summary(number).accepted) {
                    throw RpcError(Code::kUnavailable, "calibration " + std::to_string(number) + " was not accepted",
                                   "calibration.list says which were");
                  }
                  calibrations_.Use(number);
                  LoadCalibration();
                  reply(CalibrationStatus());
                }});
}

}  // namespace geond::daemon
