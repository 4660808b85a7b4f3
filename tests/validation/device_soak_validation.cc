// SPDX-License-Identifier: Apache-2.0
// Many short scans by the real drivers against the fakes, each with a fault of a random device at a random moment, in
// one process: no error without a name, laser and motor off after each, the next scan without fault succeeds, and
// descriptors do not grow. Built with a sanitizer it looks for leaks and races as well. Arguments: scans (1000), seed
// (1).
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "daemon/station.h"
#include "drivers/gpio_lines.h"
#include "drivers/modbus_turntable.h"
#include "drivers/u3v_rangefinder.h"
#include "sim/fake_bench.h"
#include "tests/sim/mounted_gpio_chip.h"

namespace geond {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestToOff(100);

sim::StationOptions World() {
  sim::StationOptions options;
  options.assumed = sim::MakeStation(0.450, 0.489, 0.060, 32, 32);
  options.turntable.step = 2.0 * 3.14159265358979323846 / 36000.0;
  options.exposure_time = milliseconds(1);
  options.threads = 1;
  return options;
}

sim::Scene Egg() {
  sim::Scene scene;
  Geon egg;
  egg.type = GeonType::kEllipsoid;
  egg.size = {0.03, 0.03, 0.045};
  egg.X_TG = Pose::Translation({0.0, 0.0, 0.045});
  scene.parts.push_back({"egg", egg});
  return scene;
}

drivers::GpioWire Wire(sim::BenchLine line, bool active_low = false) {
  drivers::GpioWire wire;
  wire.chip = sim::kGpioChipPath;
  wire.line = sim::kBenchLineNames[line];
  wire.active_low = active_low;
  return wire;
}

daemon::StationDevices Devices(sim::FakeBench& bench) {
  daemon::StationDevices devices;
  drivers::GpioLinesOptions lines;
  lines.laser = Wire(sim::kLaserLine);
  lines.motor = Wire(sim::kMotorLine);
  lines.emergency_stop = Wire(sim::kStopLine, true);
  lines.door = Wire(sim::kDoorLine, true);
  lines.debounce = milliseconds(1);
  lines.may_be_absent = true;
  devices.lines = std::make_unique<drivers::GpioLines>(lines);
  drivers::ModbusTurntableOptions table;
  table.profile = drivers::ReadDriveProfile(std::string(GEOND_SOURCE_DIR) + "/config/drives/oriental_blv_r.toml");
  table.address.serial_device = bench.drive().serial_device();
  table.address.response_timeout = milliseconds(20);
  table.speed = 40.0;
  table.acceleration = 400.0;
  table.settle_time = milliseconds(0);
  table.poll_period = milliseconds(2);
  table.stall_time = milliseconds(100);
  table.motion_timeout = milliseconds(200);
  devices.turntable = std::make_unique<drivers::ModbusTurntable>(table);
  drivers::U3vRangefinderOptions camera;
  camera.pixel_format = "Coord3D_C32f";
  camera.control.response_time = milliseconds(20);
  camera.control.longest_response_time = milliseconds(20);
  camera.may_be_absent = true;
  devices.rangefinder =
      std::make_unique<drivers::U3vRangefinder>([&bench] { return sim::OpenFakeCamera(bench.camera()); }, camera);
  return devices;
}

// One scan; what it ended in.
std::string Scan(daemon::Station& station, std::stop_token stop) {
  try {
    const daemon::ActiveStation active(station, stop);
    for (int view = 0; view < 3; ++view) station.Expose(2.1 * view, stop);
    return "done";
  } catch (const DeviceError& error) {
    return error.thing() + ": " + error.call().substr(0, error.call().find(' '));
  } catch (const Cancelled&) {
    return "cancelled";
  }
}

int Descriptors() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

int Main(int scans, std::uint64_t seed) {
  sim::FakeBench bench(std::make_shared<sim::SimStation>(Egg(), World()));
  const sim::MountedGpioChip mounted(bench.chip());
  daemon::StationOptions options;
  options.frame_timeout = milliseconds(100);
  daemon::Station station(Devices(bench), World().assumed, options);
  std::mt19937_64 random(seed);
  std::map<std::string, int> ends;
  int bad = 0, descriptors = 0;
  for (int scan = 0; scan < scans; ++scan) {
    const auto device = sim::kDevices[random() % sim::kDevices.size()];
    const auto fault = sim::kFaults[random() % sim::kFaults.size()];
    const auto moment = std::chrono::microseconds(random() % 400'000);
    {
      std::jthread saboteur([&] {
        std::this_thread::sleep_for(moment);
        bench.SetFault(device, fault);
      });
      ++ends[Scan(station, {})];
    }
    std::string unsafe;
    if (station.lines().laser()) unsafe += " laser's wire on after the fault;";
    if (station.lines().motor()) unsafe += " motor's wire on after the fault;";
    bench.SetFault(device, sim::Fault::kNone);
    std::string next = "not reset";
    for (int attempt = 0; attempt < 5 && next != "done"; ++attempt) {
      try {
        station.Reset();
        next = Scan(station, {});
      } catch (const DeviceError& error) {
        next = error.what();
        std::this_thread::sleep_for(milliseconds(5));
      }
    }
    // The bench looks at its wires every millisecond, or when it has the processor.
    const auto end = std::chrono::steady_clock::now() + kLongestToOff;
    while ((bench.laser_shines() || bench.table_turns()) && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    if (bench.laser_shines()) unsafe += " laser on;";
    if (bench.table_turns()) unsafe += " table turning;";
    if (!unsafe.empty() || next != "done") {
      ++bad;
      std::printf("scan %d, %s %s:%s next: %s\n", scan, std::string(sim::DeviceName(device)).c_str(),
                  std::string(sim::FaultName(fault)).c_str(), unsafe.empty() ? " safe;" : unsafe.c_str(), next.c_str());
    }
    if (scan == 20) descriptors = Descriptors();
  }
  std::printf("\n%d scans with a fault each, and as many after a reset:\n", scans);
  for (const auto& [end, times] : ends) std::printf("  %6d  %s\n", times, end.c_str());
  const int more = descriptors > 0 ? Descriptors() - descriptors : 0;
  std::printf("%d not safe or not mended; %d descriptors more at the end than after 20 scans\n", bad, more);
  return bad == 0 && more <= 0 ? 0 : 1;
}

}  // namespace
}  // namespace geond

int main(int count, char** arguments) {
  return geond::Main(count > 1 ? std::atoi(arguments[1]) : 1000,
                     count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1);
}
