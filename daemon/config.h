// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace geond::daemon {

// What geond can be told. Units are those of the keys; config_keys.cc says of each its key, default, range and meaning.
struct Config {
  std::string station_kind = "simulated";
  std::string station_simulation = "sim.toml";
  std::string station_scene;
  std::string station_trigger = "software";
  int frame_timeout_ms = 2000;
  std::string station_calibration;

  std::string rangefinder_driver = "u3v";
  std::string rangefinder_identity;
  std::string rangefinder_pixel_format = "Coord3D_C16";
  std::string rangefinder_trigger_line = "Line0";
  double rangefinder_exposure_us = 0.0;

  std::string turntable_profile = "drives/oriental_blv_r.toml";
  std::string turntable_serial = "/dev/ttyUSB0";
  std::string turntable_host;
  int turntable_port = 502;
  int turntable_unit = 1;
  int turntable_baud = 0;
  std::string turntable_parity = "profile";
  int turntable_response_ms = 50;
  double turntable_gear_ratio = 1.0;
  double turntable_speed_deg_per_s = 30.0, turntable_acceleration_deg_per_s2 = 60.0;
  double turntable_tolerance_deg = 0.03;
  int turntable_settle_ms = 200;
  double turntable_min_angle_deg = -1e6, turntable_max_angle_deg = 1e6;

  std::string lines_chip = "/dev/gpiochip0";
  std::string lines_laser = "0", lines_motor = "1", lines_emergency_stop = "!2", lines_door = "!3";
  std::string lines_lamp, lines_trigger;
  std::string lines_input_bias = "as_is";
  int lines_trigger_pulse_us = 500;
  int lines_debounce_ms = 20;

  int scan_views = 8;
  double scan_first_angle_deg = 0.0;
  int scan_triangles = 3000;
  double scan_detail = 0.5;
  bool scan_picture = true;
  int scan_threads = 0;

  std::string api_unix_socket = "/run/geond/geond.sock";
  std::string api_address = "127.0.0.1";
  int api_port = 7100;
  std::string api_tokens;
  int api_max_clients = 256;
  int api_max_requests_per_s = 2000;
  int api_max_line_kb = 1024;
  int api_max_unread_kb = 8192;

  std::string http_address = "127.0.0.1";
  int http_port = 7180;
  std::string http_certificate, http_key;
  std::string http_page = "/usr/share/geond/page";

  std::string robot_address = "127.0.0.1";
  int robot_port = 7110;
  std::string robot_allow;
  std::string robot_dialect = "PLAIN";
  double robot_base_x_mm = 0.0, robot_base_y_mm = 0.0, robot_base_z_mm = 0.0;
  double robot_base_roll_deg = 0.0, robot_base_pitch_deg = 0.0, robot_base_yaw_deg = 0.0;
  double gripper_opening_mm = 85.0, gripper_finger_length_mm = 45.0, gripper_finger_width_mm = 20.0;
  double gripper_finger_thickness_mm = 10.0, gripper_clearance_mm = 4.0;

  std::string store_folder = "/var/lib/geond";
  int store_max_age_days = 0;
  double store_max_size_gb = 0.0;
  int store_min_free_mb = 100;

  std::string log_level = "info";

  // The folder of the file it came from: relative paths start there. Empty: the working directory.
  std::filesystem::path folder;

  bool operator==(const Config&) const = default;
};

// One key of the configuration file.
struct ConfigKey {
  using Field = std::variant<bool*, int*, double*, std::string*>;
  std::string_view name;            // "scan.views": table and key
  Field (*field)(Config&);
  double low = 0.0, high = 0.0;     // of a number
  std::vector<std::string_view> choices;  // of a text; empty: any
  std::string_view sentence;        // what it does, for a person
  bool reloadable = false;          // takes effect on SIGHUP, without a restart
};
const std::vector<ConfigKey>& ConfigKeys();

// Reads a file. Throws FileError if it cannot be read; ConfigError naming file, line and key for broken TOML, an unknown
// key (with the nearest known), a wrong type or a value out of range.
Config ReadConfig(const std::filesystem::path& path);
// The same from text; `name` stands for the file in errors.
Config ParseConfig(std::string_view text, const std::string& name);
// Sets one key from "table.key=value", as the command line has it. Throws ConfigError.
void SetConfigKey(Config& config, const std::string& assignment);
// Throws ConfigError if keys that are each allowed do not go together.
void CheckConfig(const Config& config, const std::string& name);

// The file that says what `config` says, every key with its unit, range and sentence: config/geond.toml for the defaults.
std::string ConfigText(Config config);
// The keys whose values differ.
std::vector<const ConfigKey*> ChangedKeys(Config before, Config after);

}  // namespace geond::daemon
