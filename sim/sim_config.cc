// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_config.h"

#include <numbers>
#include <stdexcept>

#include "sim/toml_reader.h"

namespace geond::sim {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kDegree = std::numbers::pi / 180.0;

std::chrono::nanoseconds Milliseconds(double ms) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(ms * 1e6));
}

void ReadSensor(TomlReader reader, StationOptions& options) {
  const double distance = kMillimetre * reader.Number("distance_mm", 450, 100, 5000);
  const double elevation = kDegree * reader.Number("elevation_deg", 28, -10, 85);
  const double look_at = kMillimetre * reader.Number("look_at_height_mm", 60, 0, 1000);
  const int columns = reader.Integer("columns", 320, 16, 4096);
  const int rows = reader.Integer("rows", 320, 16, 4096);
  const double field = kMillimetre * reader.Number("field_mm", 260, 10, 5000);
  const double noise = kMillimetre * reader.Number("depth_noise_mm", 0.2, 0, 50);
  options.assumed = MakeStation(distance, elevation, look_at, columns, rows, field, noise);
  CameraOptions& camera = options.camera;
  camera.noise_distance = kMillimetre * reader.Number("noise_distance_mm", 450, 10, 5000);
  camera.dropout_begin = kDegree * reader.Number("dropout_begin_deg", 75, 0, 90);
  camera.dropout_end = kDegree * reader.Number("dropout_end_deg", 86, 0, 90);
  if (camera.dropout_end < camera.dropout_begin) reader.Fail("dropout_end_deg", "is less than dropout_begin_deg");
  camera.mixed_pixel_probability = reader.Number("mixed_pixel_probability", 0.05, 0, 1);
  camera.mixed_pixel_jump = kMillimetre * reader.Number("mixed_pixel_jump_mm", 10, 0.1, 1000);
  camera.depth_quantum = kMillimetre * reader.Number("depth_quantum_mm", 0.02, 0, 10);
  options.sensor_error.depth_scale = 0.01 * reader.Number("depth_scale_error_percent", 0, -10, 10);
  options.sensor_error.depth_offset = kMillimetre * reader.Number("depth_offset_error_mm", 0, -20, 20);
  options.sensor_error.focal = 0.01 * reader.Number("focal_error_percent", 0, -10, 10);
  options.exposure_time = Milliseconds(reader.Number("exposure_time_ms", 40, 0, 10000));
  reader.Finish();
}

void ReadTable(TomlReader reader, StationOptions& options) {
  TurntableOptions& table = options.turntable;
  table.max_speed = kDegree * reader.Number("max_speed_deg_per_s", 57.3, 0.1, 3600);
  table.acceleration = kDegree * reader.Number("acceleration_deg_per_s2", 114.6, 0.1, 36000);
  table.backlash = kDegree * reader.Number("backlash_deg", 0.03, 0, 10);
  table.step = kDegree * reader.Number("step_deg", 0, 0, 10);
  table.angle_noise = kDegree * reader.Number("angle_noise_deg", 0.006, 0, 10);
  table.angle_resolution = kDegree * reader.Number("angle_resolution_deg", 0.006, 0, 10);
  options.homing_time = Milliseconds(reader.Number("homing_time_ms", 2000, 0, 60000));
  options.motion_time_limit = Milliseconds(reader.Number("motion_time_limit_ms", 20000, 100, 600000));
  options.axis_error.tilt = kDegree * reader.Number("axis_tilt_deg", 0.1, -10, 10);
  options.axis_error.tilt_azimuth = kDegree * reader.Number("axis_tilt_azimuth_deg", 40, -360, 360);
  options.axis_error.offset_x = kMillimetre * reader.Number("axis_offset_x_mm", 0.1, -50, 50);
  options.axis_error.offset_y = kMillimetre * reader.Number("axis_offset_y_mm", -0.1, -50, 50);
  reader.Finish();
}

}  // namespace

SimConfig ReadSimConfig(const std::filesystem::path& path) {
  const toml::table root = path.empty() ? toml::table() : ReadToml(path);
  TomlReader reader(root, path, "");
  SimConfig config;
  config.scene_file = path.parent_path() / reader.Text("scene", "scenes/bowling_pin.toml");
  config.station.seed = static_cast<std::uint64_t>(reader.Integer("seed", 1, 0, 2147483647));
  config.station.threads = reader.Integer("threads", 0, 0, 1024);
  config.station.real_time_factor = reader.Number("real_time_factor", 0, 0, 100);
  config.station.reply_time = Milliseconds(reader.Number("reply_time_ms", 2, 0, 1000));
  ReadSensor(reader.Table("rangefinder"), config.station);
  ReadTable(reader.Table("turntable"), config.station);
  TomlReader faults = reader.Table("faults");
  for (const Device device : kDevices) {
    const std::string word = faults.Text(DeviceName(device), "none");
    try {
      config.faults[device] = FaultFromName(word);
    } catch (const std::invalid_argument& error) {
      faults.Fail(DeviceName(device), error.what());
    }
  }
  faults.Finish();
  reader.Finish();
  return config;
}

std::shared_ptr<SimStation> OpenSimStation(const SimConfig& config, const std::filesystem::path& scene_file) {
  auto station =
      std::make_shared<SimStation>(ReadScene(scene_file.empty() ? config.scene_file : scene_file), config.station);
  for (const auto& [device, fault] : config.faults) station->SetFault(device, fault);
  return station;
}

}  // namespace geond::sim
