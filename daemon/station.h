// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "calib/calibrate.h"
#include "core/range/scan_folder.h"
#include "drivers/lines.h"
#include "drivers/rangefinder.h"
#include "drivers/turntable.h"

namespace geond::daemon {

// The devices of a station. `world` is what simulated ones share, and outlives them; else empty.
struct StationDevices {
  std::shared_ptr<void> world;
  std::unique_ptr<drivers::Rangefinder> rangefinder;
  std::unique_ptr<drivers::Turntable> turntable;
  std::unique_ptr<drivers::Lines> lines;
};

struct StationOptions {
  enum class Trigger { kSoftware, kWire };
  Trigger trigger = Trigger::kSoftware;
  std::chrono::milliseconds frame_timeout{2000};  // from trigger to whole image
  std::optional<calib::StationCalibration> calibration;  // corrects each image; absent: they are taken as they come
};

// A turntable, a laser that looks at it, and the wires between. Lives on the device thread, but for the calls that say
// otherwise. Whatever happens, laser and motor are off after MakeSafe, StopNow and destruction.
class Station {
 public:
  // Throws std::invalid_argument if a device is missing.
  Station(StationDevices devices, StationGeometry geometry, StationOptions options);
  ~Station();
  Station(const Station&) = delete;
  Station& operator=(const Station&) = delete;

  const StationGeometry& geometry() const { return geometry_; }

  // Finds the table's zero and switches the motor off again. Throws DeviceError, Cancelled.
  void Home(std::stop_token stop);
  // Makes ready for Expose: motor on, zero found (once), rangefinder armed, laser on. Throws DeviceError (also if the
  // emergency stop is pressed or the door open), Cancelled.
  void Start(std::stop_token stop);
  // Turns the table and takes one range image there. Throws DeviceError, TimeoutError, Cancelled.
  Exposure Expose(double table_angle, std::stop_token stop);
  // Laser off, stream ended, table stands, motor off. Never throws, allowed at any time.
  void MakeSafe() noexcept;
  // Brings every faulted device back. The zero is to be found again. Throws DeviceError.
  void Reset();
  // The devices as they are now; and the angle of the table (rad) if it can be read.
  std::vector<drivers::DeviceInfo> devices() const;
  std::optional<double> table_angle();

  // Whom to tell, in words, when a device fails between two calls, after laser and motor were switched off; on whatever
  // thread. Once this has returned, the listener before is not running any more.
  void OnFault(std::function<void(const std::string&)> listener);
  // Laser off and motion stopped at once. Any thread; never throws.
  void StopNow() noexcept;
  // What forbids work: "the emergency stop is pressed", "the door is open", or empty. Any thread. Throws DeviceError.
  std::string Hazard() const;
  // The wires, safe from any thread.
  drivers::Lines& lines() { return *devices_.lines; }

 private:
  void RefuseIfHazard(const char* call) const;
  void OnDeviceFault();
  void ThrowIfFaulted() const;

  StationDevices devices_;
  const StationGeometry geometry_;
  const StationOptions options_;
  bool homed_ = false;
  std::mutex listener_mutex_;
  std::function<void(const std::string&)> listener_;
};

// Holds a station ready to expose; safe again when it goes out of scope, however that happens.
class ActiveStation {
 public:
  ActiveStation(Station& station, std::stop_token stop);
  ~ActiveStation() { station_.MakeSafe(); }
  ActiveStation(const ActiveStation&) = delete;
  ActiveStation& operator=(const ActiveStation&) = delete;

 private:
  Station& station_;
};

// "the emergency stop is pressed", "the door is open", or empty.
std::string HazardOf(const drivers::Lines::Inputs& inputs);

}  // namespace geond::daemon
