// SPDX-License-Identifier: Apache-2.0
#include "calib/calibration_file.h"

#include <cmath>
#include <fstream>
#include <numbers>

#include <nlohmann/json.hpp>

#include "core/base/printed.h"
#include "core/base/error.h"

namespace geond::calib {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr double kDegree = std::numbers::pi / 180.0;

Json ToJson(const Pose& X) {
  const auto& q = X.rotation();
  const Eigen::Vector3d p = X.translation() * 1e3;
  return {{"position_mm", {p.x(), p.y(), p.z()}}, {"quaternion", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}};
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {
    std::ifstream file(path);
    if (!file) Fail("the file cannot be opened");
    json_ = Json::parse(file, nullptr, false);
    if (!json_.is_object()) Fail("it is not a JSON object");
  }

  double Number(const std::string& key, double low, double high) const {
    const Json& value = At(key);
    if (!value.is_number()) Fail("'" + key + "' is not a number");
    const double number = value.get<double>();
    if (!(number >= low && number <= high)) Fail(Printed("'%s' is %g, not within %g to %g", key.c_str(), number, low, high));
    return number;
  }

  std::string Text(const std::string& key) const {
    const Json& value = At(key);
    if (!value.is_string()) Fail("'" + key + "' is not a text");
    return value.get<std::string>();
  }

  Pose PoseAt(const std::string& key) const {
    double p[3], q[4];
    for (int k = 0; k < 3; ++k) p[k] = Number(key + "/position_mm/" + std::to_string(k), -1e5, 1e5) * 1e-3;
    const char* names[] = {"w", "x", "y", "z"};
    for (int k = 0; k < 4; ++k) q[k] = Number(key + "/quaternion/" + names[k], -1.001, 1.001);
    const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
    if (std::abs(rotation.norm() - 1.0) > 1e-3) Fail("'" + key + "/quaternion' is no rotation");
    return {rotation, Eigen::Vector3d(p[0], p[1], p[2])};
  }

  [[noreturn]] void Fail(const std::string& cause) const {
    throw FileError(path_.string(), "read calibration", cause, "Calibrate the station again, or restore the file");
  }

 private:
  const Json& At(const std::string& key) const {
    const Json::json_pointer at("/" + key);
    if (!json_.contains(at)) Fail("'" + key + "' is missing");
    return json_.at(at);
  }

  std::filesystem::path path_;
  Json json_;
};

}  // namespace

void WriteCalibration(const StationCalibration& calibration, const std::filesystem::path& path) {
  const SensorModel& sensor = calibration.station.sensor;
  const Json json = {
      {"format", "geond calibration"},
      {"version", kVersion},
      {"number", calibration.number},
      {"name", calibration.name},
      {"date", calibration.date},
      {"X_WS", ToJson(calibration.station.X_WS)},
      {"X_WT", ToJson(calibration.station.X_WT)},
      {"work_space",
       {{"object_radius_mm", calibration.station.object_radius * 1e3},
        {"object_height_mm", calibration.station.object_height * 1e3},
        {"table_clearance_mm", calibration.station.table_clearance * 1e3}}},
      {"sensor",
       {{"projection", sensor.projection == SensorModel::Projection::kPerspective ? "perspective" : "orthographic"},
        {"columns", sensor.columns}, {"rows", sensor.rows},
        {"focal_u", sensor.focal_u}, {"focal_v", sensor.focal_v},
        {"center_u", sensor.center_u}, {"center_v", sensor.center_v},
        {"min_depth_mm", sensor.min_depth * 1e3}, {"max_depth_mm", sensor.max_depth * 1e3},
        {"depth_noise_mm", sensor.depth_noise * 1e3},
        {"depth_scale", calibration.depth_scale}, {"depth_offset_mm", calibration.depth_offset * 1e3}}},
      {"found",
       {{"axis_direction_sigma_deg", calibration.axis_direction_sigma / kDegree},
        {"axis_position_sigma_mm", calibration.axis_position_sigma * 1e3},
        {"scale_sigma", calibration.scale_sigma},
        {"check_error_mm", calibration.check_error * 1e3}}}};
  std::filesystem::path part = path;
  part += ".part";
  {
    std::ofstream file(part);
    file << json.dump(2) << "\n";
    file.flush();
    if (!file) throw FileError(path.string(), "write calibration", "the file cannot be written", "Check folder and space");
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) throw FileError(path.string(), "write calibration", error.message(), "Check the folder's permissions");
}

StationCalibration ReadCalibration(const std::filesystem::path& path) {
  const Reader read(path);
  if (read.Text("format") != "geond calibration") read.Fail("it is no calibration");
  const double version = read.Number("version", 1, 1e6);
  if (version != kVersion) read.Fail(Printed("its version is %g, this program reads %d", version, kVersion));
  StationCalibration found;
  found.number = static_cast<int>(read.Number("number", 0, 1e9));
  found.name = read.Text("name");
  found.date = read.Text("date");
  StationGeometry& station = found.station;
  station.X_WS = read.PoseAt("X_WS");
  station.X_WT = read.PoseAt("X_WT");
  station.object_radius = read.Number("work_space/object_radius_mm", 1, 1e5) * 1e-3;
  station.object_height = read.Number("work_space/object_height_mm", 1, 1e5) * 1e-3;
  station.table_clearance = read.Number("work_space/table_clearance_mm", 0, 1e3) * 1e-3;
  SensorModel& sensor = station.sensor;
  const std::string projection = read.Text("sensor/projection");
  if (projection != "perspective" && projection != "orthographic") read.Fail("'sensor/projection' is unknown");
  sensor.projection = projection == "perspective" ? SensorModel::Projection::kPerspective
                                                  : SensorModel::Projection::kOrthographic;
  sensor.columns = static_cast<int>(read.Number("sensor/columns", 1, 1e5));
  sensor.rows = static_cast<int>(read.Number("sensor/rows", 1, 1e5));
  sensor.focal_u = read.Number("sensor/focal_u", 1e-6, 1e9);
  sensor.focal_v = read.Number("sensor/focal_v", 1e-6, 1e9);
  sensor.center_u = read.Number("sensor/center_u", -1e6, 1e6);
  sensor.center_v = read.Number("sensor/center_v", -1e6, 1e6);
  sensor.min_depth = read.Number("sensor/min_depth_mm", 0, 1e9) * 1e-3;
  sensor.max_depth = read.Number("sensor/max_depth_mm", 0, 1e9) * 1e-3;
  sensor.depth_noise = read.Number("sensor/depth_noise_mm", 0, 1e3) * 1e-3;
  found.depth_scale = read.Number("sensor/depth_scale", 0.5, 2);
  found.depth_offset = read.Number("sensor/depth_offset_mm", -1e3, 1e3) * 1e-3;
  found.axis_direction_sigma = read.Number("found/axis_direction_sigma_deg", 0, 180) * kDegree;
  found.axis_position_sigma = read.Number("found/axis_position_sigma_mm", 0, 1e6) * 1e-3;
  found.scale_sigma = read.Number("found/scale_sigma", 0, 1e6);
  found.check_error = read.Number("found/check_error_mm", -1e6, 1e6) * 1e-3;
  return found;
}

}  // namespace geond::calib
