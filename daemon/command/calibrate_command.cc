// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/calibrate_command.h"

#include <array>

#include "calib/calibrate.h"
#include "calib/calibration_file.h"
#include "core/base/error.h"
#include "core/base/printed.h"
#include "daemon/calibration_store.h"
#include "daemon/command/service_client.h"

namespace geond::daemon {
namespace {

std::string Lines(const Json& list, const char* before) {
  std::string text;
  for (const Json& line : list) text += "\n  " + std::string(before) + line.get<std::string>();
  return text;
}

CommandResult Outcome(Json json) {
  const bool accepted = json["accepted"] == true;
  CommandResult result;
  result.text = accepted ? "accepted" : "REJECTED";
  result.text += Lines(json["reasons"], "- ") + Lines(json["notes"], "");
  result.json = std::move(json);
  result.exit_code = accepted ? 0 : 1;
  return result;
}

// --- recorded scans ---

std::vector<calib::TargetPlacement> ReadPlacements(const std::vector<std::filesystem::path>& folders, double diameter,
                                                   std::optional<StationGeometry>& station) {
  std::vector<calib::TargetPlacement> placements;
  for (const auto& folder : folders) {
    RecordedScan scan = ReadScan(folder);
    if (scan.calibration) {
      throw FileError(folder.string(), "calibrate", "its images are already corrected by a calibration",
                      "Scan the sphere with geon calibrate, or with the station as configured (geon calibrate --use 0)");
    }
    if (!station) station = scan.station;
    calib::TargetPlacement placement{diameter, {}};
    for (auto& view : scan.views) placement.exposures.push_back(std::move(view.exposure));
    placements.push_back(std::move(placement));
  }
  return placements;
}

CommandResult SolveRecorded(const CalibrateArguments& arguments, const CommandContext& context) {
  std::optional<StationGeometry> station;
  const auto target = ReadPlacements(arguments.target_scans, arguments.target, station);
  const auto check = ReadPlacements(arguments.check_scans, arguments.check, station);
  if (!station) throw std::invalid_argument("calibrate: no scan of the target is given (--target)");
  calib::CalibrationResult found = calib::CalibrateStation(*station, target, check, {}, context.stop, context.on_step);
  found.calibration.date = DateNow();
  if (found.accepted && !arguments.output.empty()) calib::WriteCalibration(found.calibration, arguments.output);
  return Outcome({{"accepted", found.accepted},
                  {"check_error_mm", found.calibration.check_error * 1e3},
                  {"reasons", found.reasons},
                  {"notes", found.notes}});
}

// --- a station ---

// Where a placement stands, for a person and (x, y, height of the stand, in mm) for the simulated table.
struct Place {
  const char* words;
  double x, y, lift;
};
constexpr std::array<Place, 4> kTargetPlaces = {{{"near the edge of what the sensor sees, flat on the table", 45, 0, 0},
                                                 {"near the middle, on a stand about as high as the sphere", -15, 30, 40},
                                                 {"near the edge again, on another side, on a low stand", 0, -55, 15},
                                                 {"half-way out, on another stand", -35, -20, 25}}};
constexpr Place kCheckPlace = {"near the middle, flat on the table", 5, 10, 0};

std::string SphereScene(const Place& place, double diameter) {
  const double radius = 0.5e3 * diameter;
  std::string toml = Printed("name = \"sphere\"\n[[geon]]\ntype = \"ellipsoid\"\nsize_mm = [%.6f, %.6f, %.6f]\n"
                            "position_mm = [%g, %g, %.6f]\n", radius, radius, radius, place.x, place.y, place.lift + radius);
  if (place.lift > 0) {
    toml += Printed("[[geon]]\ntype = \"cylinder\"\nsize_mm = [7, 7, %g]\nposition_mm = [%g, %g, %g]\n", 0.5 * place.lift,
                   place.x, place.y, 0.5 * place.lift);
  }
  return toml;
}

class Guide {
 public:
  Guide(const CalibrateArguments& arguments, const CommandContext& context)
      : arguments_(arguments), context_(context), client_(arguments.socket, context.stop),
        simulated_(client_.greeting()["params"].value("station", "") == "simulated") {}

  ServiceClient& client() { return client_; }

  CommandResult Run() {
    number_ = client_.Call("calibration.begin", {{"target_mm", 1e3 * arguments_.target}, {"check_mm", 1e3 * arguments_.check}})
                  .at("calibration").get<int>();
    said_ = Printed("Calibration %d. It takes two matt spheres of known diameter: the target (%.2f mm) and the check sphere "
                   "(%.2f mm).\nA stand is thinner than its sphere, nothing else is on the table, and nothing may move on it "
                   "while it turns.", number_, 1e3 * arguments_.target, 1e3 * arguments_.check);
    for (int k = 0; k < arguments_.placements; ++k) {
      PlaceSphere(kTargetPlaces[k], false, Printed("Placement %d of %d: put the target", k + 1, arguments_.placements));
    }
    PlaceSphere(kCheckPlace, true, "Now put the check sphere");
    if (context_.on_step) context_.on_step("calibrate", 0, 0);
    CommandResult result = Outcome(client_.Call("calibration.solve", {{"calibration", number_}}));
    result.text = Printed("calibration %d ", number_) + result.text;
    if (simulated_) client_.Call("simulation.scene", {{"configured", true}});
    return result;
  }

 private:
  void Ask(const std::string& what) {
    if (simulated_) return;
    if (!context_.ask || !context_.ask(said_ + (said_.empty() ? "" : "\n") + what + ", then press Enter: ")) {
      if (context_.stop.stop_requested()) throw Cancelled();
      throw std::invalid_argument("calibrate: nobody answers at the terminal (programs call calibration.begin, .place and "
                                  ".solve over the socket)");
    }
    said_.clear();
  }

  void PlaceSphere(const Place& place, bool check, const std::string& what) {
    const double diameter = check ? arguments_.check : arguments_.target;
    while (true) {
      Ask(what + " " + place.words);
      if (simulated_) client_.Call("simulation.scene", {{"toml", SphereScene(place, diameter)}});
      if (context_.on_step) context_.on_step(check ? "check sphere" : "target", 0, arguments_.views);
      const Json taken = client_.Call("calibration.place",
                                      {{"calibration", number_}, {"check", check}, {"views", arguments_.views}});
      const std::string found = Printed("The sphere was found in %d of %d images.", taken["found"].get<int>(), arguments_.views);
      if (taken["kept"] == true) {
        said_ = found;
        return;
      }
      const std::string remedy = taken["remedy"].get<std::string>();
      if (simulated_) throw DeviceError("station", "calibrate", found, remedy);
      said_ = found + " " + remedy;
    }
  }

  const CalibrateArguments& arguments_;
  const CommandContext& context_;
  ServiceClient client_;
  const bool simulated_;
  int number_ = 0;
  std::string said_;
};

std::string InForceText(const Json& calibration) {
  std::string text;
  if (calibration["calibration"] == 0) {
    text = "no calibration is in force: the station is used as configured";
  } else {
    text = Printed("calibration %d of %s is in force: check sphere %+.3f mm off, axis known to %.3f deg and %.3f mm",
                  calibration["calibration"].get<int>(), calibration["date"].get<std::string>().c_str(),
                  calibration["check_error_mm"].get<double>(), calibration["axis_direction_sigma_deg"].get<double>(),
                  calibration["axis_position_sigma_mm"].get<double>());
  }
  const std::string problem = calibration["problem"].get<std::string>();
  return problem.empty() ? text : text + "\n" + problem;
}

CommandResult ListCalibrations(ServiceClient& client) {
  CommandResult result;
  result.json = client.Call("calibration.list");
  for (const Json& one : result.json["calibrations"]) {
    const char* state = one["solved"] != true ? "not solved" : one["accepted"] == true ? "accepted" : "rejected";
    result.text += Printed("%s%4d %s  %-10s %s", result.text.empty() ? "" : "\n", one["calibration"].get<int>(),
                          one["date"].get<std::string>().c_str(), state, one["in_force"] == true ? "in force" : "");
    if (one["accepted"] != true) result.text += Lines(one["reasons"], "     ");
  }
  if (result.text.empty()) result.text = "the station was never calibrated";
  return result;
}

}  // namespace

CommandResult Calibrate(const CalibrateArguments& arguments, const CommandContext& context) {
  if (!arguments.target_scans.empty() || !arguments.check_scans.empty()) return SolveRecorded(arguments, context);
  Guide guide(arguments, context);
  if (arguments.list) return ListCalibrations(guide.client());
  if (!arguments.show && !arguments.use) return guide.Run();
  Json in_force = arguments.use ? guide.client().Call("calibration.use", {{"calibration", *arguments.use}})
                                : guide.client().Call("calibration.show");
  std::string text = InForceText(in_force);
  return {std::move(in_force), std::move(text)};
}

}  // namespace geond::daemon
