// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "core/range/scan_folder.h"

namespace geond::daemon {

// A calibration of the station as its folder tells it.
struct StoredCalibration {
  int number = 0;
  std::string date;                // of its beginning, ISO 8601
  double target_diameter = 0.0;    // m
  double check_diameter = 0.0;     // m
  int targets = 0, checks = 0;     // placements taken
  bool solved = false, accepted = false;
  double check_error = 0.0;        // m
  std::vector<std::string> reasons, notes;
};

// The calibrations of a station on disk: FOLDER/0001 and so on, each with the scans of its target (target_1, ..) and check
// object (check_1, ..), its result in words, and what was found; FOLDER/current.json says which one is in force. Lives on
// the I/O thread, but for Placements, KeepResult and KeepPlacement, which touch one calibration alone. All calls throw
// FileError.
class CalibrationStore {
 public:
  explicit CalibrationStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // A new one, dated; returns its number. Diameters in m.
  int Begin(double target_diameter, double check_diameter, const std::string& date) const;
  // Puts the exposures of one placement of target or check object on disk; returns how many there are then.
  int KeepPlacement(int number, bool check, const RecordedScan& scan) const;
  std::vector<calib::TargetPlacement> Placements(int number, bool check) const;
  // What came out, in words, and the calibration itself if it was accepted.
  void KeepResult(int number, const calib::CalibrationResult& result) const;

  // Oldest first.
  std::vector<StoredCalibration> List() const;
  // Throws FileError if there is none of this number.
  StoredCalibration Summary(int number) const;
  calib::StationCalibration Read(int number) const;
  // The number in force; 0: none. Use(0) goes back to the station as configured.
  int Current() const;
  void Use(int number) const;

 private:
  std::filesystem::path Folder(int number) const;
  std::filesystem::path PlacementFolder(int number, bool check, int placement) const;
  int CountPlacements(int number, bool check) const;

  std::filesystem::path folder_;
};

// Now, in UTC, as ISO 8601 to the second.
std::string DateNow();

}  // namespace geond::daemon
