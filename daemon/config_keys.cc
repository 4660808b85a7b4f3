// SPDX-License-Identifier: Apache-2.0
#include "daemon/config.h"

namespace geond::daemon {
namespace {

using Field = ConfigKey::Field;

template <auto Member>
Field At(Config& config) {
  return &(config.*Member);
}

}  // namespace

const std::vector<ConfigKey>& ConfigKeys() {
  static const std::vector<ConfigKey> keys = {
      {"station.kind", At<&Config::station_kind>, 0, 0, {"simulated", "hardware"},
       "Which station to run. With \"simulated\" nothing moves and no laser shines."},
      {"station.simulation", At<&Config::station_simulation>, 0, 0, {},
       "File that describes the simulated station, relative to this one."},
      {"station.scene", At<&Config::station_scene>, 0, 0, {},
       "Scene on the simulated table, relative to this file; empty: the one that the simulation's file names."},
      {"station.trigger", At<&Config::station_trigger>, 0, 0, {"software", "wire"},
       "How an image is asked for: by a command to the rangefinder or a pulse on the trigger wire."},
      {"station.frame_timeout_ms", At<&Config::frame_timeout_ms>, 10, 600000, {},
       "A range image that takes longer than this from its trigger is a fault."},
      {"station.calibration", At<&Config::station_calibration>, 0, 0, {},
       "File that says where rangefinder and table stand, relative to this one; a hardware station needs it."},

      {"rangefinder.driver", At<&Config::rangefinder_driver>, 0, 0, {"u3v"},
       "Kind of the rangefinder of a hardware station: u3v is a USB3 Vision compatible range camera."},
      {"rangefinder.identity", At<&Config::rangefinder_identity>, 0, 0, {},
       "Its GUID or serial number; empty: the only one that is plugged in."},
      {"rangefinder.pixel_format", At<&Config::rangefinder_pixel_format>, 0, 0,
       {"Coord3D_C16", "Coord3D_C32f", "Coord3D_ABC16", "Coord3D_ABC32f"}, "How depth is sent, as the camera names it."},
      {"rangefinder.trigger_line", At<&Config::rangefinder_trigger_line>, 0, 0, {},
       "The camera's input that the trigger wire is on, for station.trigger = \"wire\"."},
      {"rangefinder.exposure_us", At<&Config::rangefinder_exposure_us>, 0, 1e7, {},
       "Exposure time; 0: as the camera has it."},

      {"turntable.profile", At<&Config::turntable_profile>, 0, 0, {},
       "How its drive is spoken to: a file of config/drives, relative to this one."},
      {"turntable.serial", At<&Config::turntable_serial>, 0, 0, {},
       "Serial port of the drive (best a name below /dev/serial/by-path); empty: it is on the network."},
      {"turntable.host", At<&Config::turntable_host>, 0, 0, {},
       "Address of a drive on the network (Modbus TCP); turntable.serial must be empty then."},
      {"turntable.port", At<&Config::turntable_port>, 1, 65535, {}, "Its TCP port."},
      {"turntable.unit", At<&Config::turntable_unit>, 1, 247, {}, "Its Modbus unit number."},
      {"turntable.baud", At<&Config::turntable_baud>, 0, 4000000, {}, "Speed of the serial line; 0: as the profile says."},
      {"turntable.parity", At<&Config::turntable_parity>, 0, 0, {"profile", "none", "even", "odd"},
       "Parity of the serial line."},
      {"turntable.response_ms", At<&Config::turntable_response_ms>, 10, 5000, {},
       "A reply that takes longer is lost. Laser and motor stay on for so long when the drive falls silent."},
      {"turntable.gear_ratio", At<&Config::turntable_gear_ratio>, -10000, 10000, {},
       "Turns of the motor for one of the table; negative: they turn opposite ways."},
      {"turntable.speed_deg_per_s", At<&Config::turntable_speed_deg_per_s>, 0.1, 3600, {}, "Speed of the table."},
      {"turntable.acceleration_deg_per_s2", At<&Config::turntable_acceleration_deg_per_s2>, 0.1, 36000, {},
       "Acceleration of the table."},
      {"turntable.tolerance_deg", At<&Config::turntable_tolerance_deg>, 0.001, 10, {},
       "Nearer than this to where it is to go, it has arrived."},
      {"turntable.settle_ms", At<&Config::turntable_settle_ms>, 0, 60000, {},
       "From its arrival to the next image, for the object to stop swinging."},
      {"turntable.min_angle_deg", At<&Config::turntable_min_angle_deg>, -1e6, 1e6, {},
       "It never turns below this angle, counted over whole turns."},
      {"turntable.max_angle_deg", At<&Config::turntable_max_angle_deg>, -1e6, 1e6, {}, "Nor above this one."},

      {"lines.chip", At<&Config::lines_chip>, 0, 0, {},
       "GPIO chip that the station's wires are on: its device, name or label (gpiodetect lists them)."},
      {"lines.laser", At<&Config::lines_laser>, 0, 0, {},
       "Number or name of the line that enables the laser; a ! before it: low is on. What is let go must be off."},
      {"lines.motor", At<&Config::lines_motor>, 0, 0, {}, "Line that enables the motor; empty: none."},
      {"lines.lamp", At<&Config::lines_lamp>, 0, 0, {}, "Line of the warning lamp; empty: none."},
      {"lines.trigger", At<&Config::lines_trigger>, 0, 0, {}, "Line that triggers the rangefinder; empty: none."},
      {"lines.emergency_stop", At<&Config::lines_emergency_stop>, 0, 0, {},
       "Line that says that the emergency stop is pressed; with !, low is pressed, so that a cut wire is too."},
      {"lines.door", At<&Config::lines_door>, 0, 0, {}, "Line that says that the door is open; empty: there is no door."},
      {"lines.input_bias", At<&Config::lines_input_bias>, 0, 0, {"as_is", "none", "pull_up", "pull_down"},
       "Resistors of the chip on the two inputs."},
      {"lines.trigger_pulse_us", At<&Config::lines_trigger_pulse_us>, 1, 1000000, {}, "Width of a trigger pulse."},
      {"lines.debounce_ms", At<&Config::lines_debounce_ms>, 0, 1000, {},
       "Emergency stop and door count as released only after they were quiet for so long."},

      {"scan.views", At<&Config::scan_views>, 1, 360, {},
       "Range images of a scan, evenly round the table, unless the request says otherwise.", true},
      {"scan.first_angle_deg", At<&Config::scan_first_angle_deg>, -360, 360, {},
       "Table angle of the first one, counter-clockwise seen from above.", true},
      {"scan.triangles", At<&Config::scan_triangles>, 100, 2000000, {},
       "Wanted number of triangles of the mesh.", true},
      {"scan.detail", At<&Config::scan_detail>, 0, 1, {},
       "How weak a concavity still cuts the object: 0 coarse to 1 fine.", true},
      {"scan.picture", At<&Config::scan_picture>, 0, 0, {},
       "Keep a picture of what was found (picture.png) with every scan.", true},
      {"scan.threads", At<&Config::scan_threads>, 0, 1024, {},
       "Processors to compute with; 0: all. The result is the same.", true},

      {"api.unix_socket", At<&Config::api_unix_socket>, 0, 0, {},
       "Unix socket of the service; empty: none."},
      {"api.address", At<&Config::api_address>, 0, 0, {},
       "Address to listen on. Other than loopback it needs api.tokens."},
      {"api.port", At<&Config::api_port>, 0, 65535, {},
       "TCP port of the service; 0: any free one."},
      {"api.tokens", At<&Config::api_tokens>, 0, 0, {},
       "File of lines ROLE TOKEN (read, scan, admin) for clients over TCP and HTTP, relative to this file; empty: no tokens."},
      {"api.max_clients", At<&Config::api_max_clients>, 1, 10000, {},
       "Connections at once; one more is told so and closed."},
      {"api.max_line_kb", At<&Config::api_max_line_kb>, 1, 65536, {},
       "A longer request closes its connection."},
      {"api.max_unread_kb", At<&Config::api_max_unread_kb>, 64, 1048576, {},
       "A client that leaves more than this unread is dropped."},

      {"http.address", At<&Config::http_address>, 0, 0, {},
       "Address of the page and of the same methods over HTTP. Other than loopback it needs api.tokens."},
      {"http.port", At<&Config::http_port>, -1, 65535, {},
       "TCP port of the page; 0: any free one; -1: none."},
      {"http.page", At<&Config::http_page>, 0, 0, {},
       "Folder of the page's files, relative to this file."},

      {"robot.address", At<&Config::robot_address>, 0, 0, {},
       "Address of the robot port. Other than loopback it needs robot.allow."},
      {"robot.port", At<&Config::robot_port>, -1, 65535, {},
       "TCP port where robot controllers ask; 0: any free one; -1: none."},
      {"robot.allow", At<&Config::robot_allow>, 0, 0, {},
       "Networks whose robots may connect, as \"192.168.1.0/24, 10.0.0.7\"; empty: this machine only."},
      {"robot.dialect", At<&Config::robot_dialect>, 0, 0, {"UR", "ABB", "KUKA", "FANUC", "PLAIN"},
       "How answers are written, until a controller asks for another way (DIALECT UR).", true},
      {"robot.base_x_mm", At<&Config::robot_base_x_mm>, -100000, 100000, {},
       "Place of the station's origin in the base of the robot, along x.", true},
      {"robot.base_y_mm", At<&Config::robot_base_y_mm>, -100000, 100000, {},
       "The same along y.", true},
      {"robot.base_z_mm", At<&Config::robot_base_z_mm>, -100000, 100000, {},
       "The same along z.", true},
      {"robot.base_roll_deg", At<&Config::robot_base_roll_deg>, -360, 360, {},
       "Turn of the station in the base of the robot: about x first.", true},
      {"robot.base_pitch_deg", At<&Config::robot_base_pitch_deg>, -360, 360, {},
       "The same about the base's y, after that.", true},
      {"robot.base_yaw_deg", At<&Config::robot_base_yaw_deg>, -360, 360, {},
       "The same about the base's z, last.", true},

      {"gripper.opening_mm", At<&Config::gripper_opening_mm>, 1, 1000, {},
       "Greatest opening of the parallel gripper for which grasps are sought.", true},
      {"gripper.finger_length_mm", At<&Config::gripper_finger_length_mm>, 1, 1000, {},
       "From its palm to the tips of its fingers.", true},
      {"gripper.finger_width_mm", At<&Config::gripper_finger_width_mm>, 1, 500, {},
       "Width of a finger, across the way it closes.", true},
      {"gripper.finger_thickness_mm", At<&Config::gripper_finger_thickness_mm>, 1, 500, {},
       "Thickness of a finger, along the way it closes.", true},
      {"gripper.clearance_mm", At<&Config::gripper_clearance_mm>, 0, 100, {},
       "Room to keep to everything that is not held.", true},

      {"store.folder", At<&Config::store_folder>, 0, 0, {},
       "Where scans are kept, one folder each."},

      {"log.level", At<&Config::log_level>, 0, 0, {"trace", "debug", "info", "warning", "error"},
       "How much is logged.", true},
  };
  return keys;
}

}  // namespace geond::daemon
