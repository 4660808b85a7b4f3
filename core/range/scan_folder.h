// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "core/range/range_image.h"
#include "core/range/sensor_model.h"

namespace geond {

// Where things stand at the station, and which returns are the object's.
struct StationGeometry {
  SensorModel sensor;
  Pose X_WS;                       // sensor in the station
  Pose X_WT;                       // turntable at angle 0: z along the axis, origin on the table top
  double object_radius = 0.25;     // m: work space is a cylinder about the axis, ...
  double object_height = 0.5;      // m: ... up to here
  double table_clearance = 0.001;  // m: returns lower than this over the table top are the table's
};

// X_TS of a view taken at a table angle (rad): X_TS = Inverse(X_WT * Rz(angle)) * X_WS.
Pose SensorInTurntable(const StationGeometry& station, double table_angle);

// Which station calibration a scan was made with. Station and images of the scan are as corrected by it: what the sensor
// itself read is (depth - depth_offset) / depth_scale.
struct UsedCalibration {
  int number = 0;            // of the station's calibrations, counted from 1
  std::string name, date;    // of the station; ISO 8601
  double depth_scale = 1.0;
  double depth_offset = 0.0;  // m
  bool operator==(const UsedCalibration&) const = default;
};

// A scan as it lies on disk: a folder with scan.json and one range image a view (16-bit PNG of quantised depth with
// scale and offset, or raw 32-bit floats), each with its SHA-256.
struct RecordedScan {
  struct View {
    Exposure exposure;
    SensorModel sensor;  // of this view (the station's, unless recorded otherwise)
    Pose X_TS_measured;
    std::optional<Pose> X_TS_refined;  // absent until registered
  };
  StationGeometry station;
  std::optional<UsedCalibration> calibration;  // absent: the station as configured
  bool has_table = true;  // false: a scan from elsewhere, no table plane and no axis to use
  std::vector<View> views;
  std::uint64_t seed = 0;  // of the simulation, 0 for a real station
  std::string software;    // version that wrote it
  std::string truth;       // of a simulated scan: JSON text of the true description, else empty
};

// Throws FileError naming file and key (or byte) if anything is missing, damaged (sum) or out of range.
RecordedScan ReadScan(const std::filesystem::path& folder);

// kAuto: PNG where that keeps every depth to 1e-6 m (depths within 0.13 m of each other), else floats, which lose
// nothing. kPng always: the error is at most 8e-6 of the image's range of depth.
enum class ScanImageFormat { kAuto, kPng, kFloat };

// Writes scan.json last, so that a folder with one is whole. Throws FileError; std::invalid_argument if an image has
// not the size of its sensor.
void WriteScan(const RecordedScan& scan, const std::filesystem::path& folder,
               ScanImageFormat format = ScanImageFormat::kAuto);

}  // namespace geond
