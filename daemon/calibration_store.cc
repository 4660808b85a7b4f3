// SPDX-License-Identifier: Apache-2.0
#include "daemon/calibration_store.h"

#include <algorithm>
#include <ctime>

#include <nlohmann/json.hpp>

#include "calib/calibration_file.h"
#include "core/base/error.h"
#include "core/base/printed.h"
#include "daemon/durable_file.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMillimetre = 1e-3;

json ReadObject(const fs::path& path) {
  json value = json::parse(ReadWhole(path), nullptr, false);
  if (!value.is_object()) throw FileError(path.string(), "read", "it is not a JSON object", "Restore the file or calibrate again");
  return value;
}

void MakeFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder.string(), "make folder", error.message(), "Check store.folder and its permissions");
}

}  // namespace

std::string DateNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

fs::path CalibrationStore::Folder(int number) const { return folder_ / Printed("%04d", number); }

fs::path CalibrationStore::PlacementFolder(int number, bool check, int placement) const {
  return Folder(number) / ((check ? "check_" : "target_") + std::to_string(placement));
}

int CalibrationStore::CountPlacements(int number, bool check) const {
  int count = 0;
  while (fs::exists(PlacementFolder(number, check, count + 1) / "scan.json")) ++count;
  return count;
}

int CalibrationStore::Begin(double target_diameter, double check_diameter, const std::string& date) const {
  int number = 1;
  while (fs::exists(Folder(number))) ++number;
  MakeFolder(Folder(number));
  SyncFolder(folder_);
  WriteDurably(Folder(number) / "begun.json", json{{"date", date},
                                                   {"target_diameter_mm", target_diameter / kMillimetre},
                                                   {"check_diameter_mm", check_diameter / kMillimetre},
                                                   {"software", GEOND_VERSION}}
                                                  .dump(2));
  return number;
}

int CalibrationStore::KeepPlacement(int number, bool check, const RecordedScan& scan) const {
  const int placement = CountPlacements(number, check) + 1;
  WriteScan(scan, PlacementFolder(number, check, placement));
  return placement;
}

std::vector<calib::TargetPlacement> CalibrationStore::Placements(int number, bool check) const {
  const StoredCalibration begun = Summary(number);
  std::vector<calib::TargetPlacement> placements;
  for (int k = 1; k <= (check ? begun.checks : begun.targets); ++k) {
    calib::TargetPlacement placement;
    placement.diameter = check ? begun.check_diameter : begun.target_diameter;
    for (auto& view : ReadScan(PlacementFolder(number, check, k)).views) {
      placement.exposures.push_back(std::move(view.exposure));
    }
    placements.push_back(std::move(placement));
  }
  return placements;
}

void CalibrationStore::KeepResult(int number, const calib::CalibrationResult& result) const {
  if (result.accepted) calib::WriteCalibration(result.calibration, Folder(number) / "calibration.json");
  WriteDurably(Folder(number) / "result.json", json{{"accepted", result.accepted},
                                                    {"check_error_mm", result.calibration.check_error / kMillimetre},
                                                    {"reasons", result.reasons},
                                                    {"notes", result.notes}}
                                                   .dump(2));
}

StoredCalibration CalibrationStore::Summary(int number) const {
  const fs::path folder = Folder(number);
  if (!fs::exists(folder / "begun.json")) {
    throw FileError(folder.string(), "read", "there is no calibration " + std::to_string(number), "Begin one");
  }
  const json begun = ReadObject(folder / "begun.json");
  StoredCalibration found;
  found.number = number;
  found.date = begun.value("date", "");
  found.target_diameter = begun.value("target_diameter_mm", 0.0) * kMillimetre;
  found.check_diameter = begun.value("check_diameter_mm", 0.0) * kMillimetre;
  found.targets = CountPlacements(number, false);
  found.checks = CountPlacements(number, true);
  if (fs::exists(folder / "result.json")) {
    const json result = ReadObject(folder / "result.json");
    found.solved = true;
    found.accepted = result.value("accepted", false);
    found.check_error = result.value("check_error_mm", 0.0) * kMillimetre;
    found.reasons = result.value("reasons", std::vector<std::string>());
    found.notes = result.value("notes", std::vector<std::string>());
  }
  return found;
}

std::vector<StoredCalibration> CalibrationStore::List() const {
  std::vector<StoredCalibration> all;
  for (int number = 1; fs::exists(Folder(number) / "begun.json"); ++number) all.push_back(Summary(number));
  return all;
}

calib::StationCalibration CalibrationStore::Read(int number) const {
  return calib::ReadCalibration(Folder(number) / "calibration.json");
}

int CalibrationStore::Current() const {
  const fs::path path = folder_ / "current.json";
  return fs::exists(path) ? ReadObject(path).value("calibration", 0) : 0;
}

void CalibrationStore::Use(int number) const {
  if (number > 0) Read(number);
  MakeFolder(folder_);
  WriteDurably(folder_ / "current.json", json{{"calibration", number}}.dump(2));
}

}  // namespace geond::daemon
