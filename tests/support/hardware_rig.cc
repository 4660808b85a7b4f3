// SPDX-License-Identifier: Apache-2.0
#include "tests/support/hardware_rig.h"

#include <signal.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "calib/calibration_file.h"
#include "core/base/error.h"

namespace geond {

namespace fs = std::filesystem;
using daemon::Json;

HardwareRig::HardwareRig(const Options& options) : hardware_(options.hardware), settings_(options.settings) {
  std::string name = (fs::temp_directory_path() / "geond_rig_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder can be had");
  folder_ = name;
  WriteFiles(options);
  if (!hardware_) return;
  sim::FakeDriveOptions line;
  line.baud = options.drive_baud;
  line.parity = 'N';  // a pseudo-terminal that already has all else refuses to be given a parity
  bench_ = std::make_unique<sim::FakeBench>(sim::OpenSimStation(sim::ReadSimConfig(folder_ / "sim.toml")), line);
  wires_ = std::make_unique<sim::FakeWires>(*bench_, folder_);
}

HardwareRig::~HardwareRig() {
  client_.reset();
  if (geond_ > 0) {
    kill(geond_, SIGKILL);
    sim::WaitFor(geond_);
  }
  wires_.reset();
  bench_.reset();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void HardwareRig::WriteFiles(const Options& options) {
  std::ostringstream profile;
  profile << std::ifstream(std::string(GEOND_SOURCE_DIR) + "/config/drives/oriental_blv_r.toml").rdbuf();
  std::string drive = profile.str();
  for (const std::string limit : {"lifetime_ms = 500", "value_ms = 500"}) {
    const std::size_t at = drive.find(limit);
    if (at == std::string::npos) throw std::runtime_error("the drive's profile has no " + limit);
    if (options.patient) drive.replace(at + limit.size() - 3, 3, "3000");
  }
  std::ofstream(folder_ / "drive.toml") << drive;
  const std::string size = std::to_string(options.pixels);
  std::ofstream(folder_ / "sim.toml")
      << "scene = \"" << GEOND_SOURCE_DIR << "/config/scenes/bowling_pin.toml\"\nthreads = 1\n"
      << "[rangefinder]\ncolumns = " << size << "\nrows = " << size << "\nexposure_time_ms = 20\n"
      << "[turntable]\nstep_deg = 0.01\nangle_noise_deg = 0\nangle_resolution_deg = 0.01\n";
  calib::StationCalibration calibration;
  calibration.station = sim::ReadSimConfig(folder_ / "sim.toml").station.assumed;
  calibration.name = "fake bench";
  calib::WriteCalibration(calibration, folder_ / "calibration.json");
  std::ofstream(folder_ / "geond.toml")
      << "[station]\nkind = \"" << (hardware_ ? "hardware" : "simulated") << "\"\nsimulation = \"sim.toml\"\n"
      << "calibration = \"calibration.json\"\nframe_timeout_ms = " << (options.patient ? 3000 : 1000) << "\n"
      << "[scan]\ntriangles = 1000\npicture = false\nthreads = 1\n"
      << "[api]\nunix_socket = \"" << (folder_ / "socket").string() << "\"\nport = 0\n"
      << "[http]\nport = -1\n[robot]\nport = -1\n[store]\nfolder = \"store\"\n"
      << "[rangefinder]\nidentity = \"FC0001\"\npixel_format = \"Coord3D_C32f\"\n"
      << "[turntable]\nprofile = \"" << (folder_ / "drive.toml").string() << "\"\nresponse_ms = " << (options.patient ? 1200 : 50) << "\n"
      << "serial = \"" << (folder_ / "drive").string() << "\"\nspeed_deg_per_s = " << options.table_speed
      << "\nparity = \"none\"\nacceleration_deg_per_s2 = 3600\nsettle_ms = 10\n"
      << "[lines]\nchip = \"/dev/gpiochip90\"\nlaser = \"LASER\"\nmotor = \"MOTOR\"\nlamp = \"LAMP\"\n"
      << "trigger = \"TRIGGER\"\nemergency_stop = \"!STOP_LOOP\"\ndoor = \"!DOOR_LOOP\"\n";
}

std::vector<std::string> HardwareRig::Arguments() const {
  std::vector<std::string> arguments = {GEOND_PROGRAM, "--config", (folder_ / "geond.toml").string()};
  for (const std::string& setting : settings_) {
    arguments.push_back("--set");
    arguments.push_back(setting);
  }
  return arguments;
}

int HardwareRig::Run(const std::vector<std::string>& arguments) {
  std::vector<std::string> all = Arguments();
  all.insert(all.end(), arguments.begin(), arguments.end());
  return sim::WaitFor(wires_->Start(all, folder_ / "log"));
}

void HardwareRig::Start() {
  client_.reset();
  geond_ = wires_ ? wires_->Start(Arguments(), folder_ / "log") : sim::StartBelow(Arguments(), "", {}, folder_ / "log");
  while (true) {
    try {
      client_ = std::make_unique<daemon::ServiceClient>((folder_ / "socket").string());
      client_->Call("events.subscribe");
      return;
    } catch (const DeviceError&) {
      if (waitpid(geond_, nullptr, WNOHANG) != 0) {
        geond_ = -1;
        throw std::runtime_error("geond did not start: " + Log());
      }
      std::this_thread::yield();
    }
  }
}

void HardwareRig::Kill() {
  client_.reset();
  kill(geond_, SIGKILL);
  sim::WaitFor(std::exchange(geond_, -1));
}

void HardwareRig::Signal(int number) { kill(geond_, number); }

int HardwareRig::OpenDescriptors() const {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator("/proc/" + std::to_string(geond_) + "/fd")) ++count;
  return count;
}

int HardwareRig::Stop() {
  client_.reset();
  kill(geond_, SIGTERM);
  return sim::WaitFor(std::exchange(geond_, -1));
}

std::string HardwareRig::Log() const {
  std::ostringstream text;
  text << std::ifstream(folder_ / "log").rdbuf();
  return text.str();
}

Json HardwareRig::Call(const std::string& method, const Json& params) { return client_->Call(method, params); }

Json HardwareRig::WaitForEvent(const std::string& event) {
  while (true) {
    Json params = client_->NextEvent();
    if (params["event"] == event) return params;
  }
}

Json HardwareRig::WaitForScanEnd() {
  while (true) {
    Json params = WaitForEvent("scan");
    if (params["state"] != "running") return params;
  }
}

fs::path HardwareRig::ScanFolder(int scan) const {
  char name[16];
  std::snprintf(name, sizeof name, "%06d", scan);
  return folder_ / "store" / name;
}

}  // namespace geond
