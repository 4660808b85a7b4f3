// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>

#include "core/range/range_image.h"
#include "core/range/sensor_model.h"

namespace geond::drivers {

// The life of a device, as `geon status` shows it.
enum class DeviceState { kAbsent, kIdle, kArmed, kFault };
std::string_view DeviceStateName(DeviceState state);  // "absent", "idle", "armed", "fault"

struct DeviceInfo {
  std::string name;       // "rangefinder", "turntable", "lines"
  std::string driver;     // "u3v", "tim", "modbus", "gpio", "simulated"
  std::string model;
  std::string serial;     // or GUID: what identifies the one device
  DeviceState state = DeviceState::kAbsent;
  std::string fault;      // in words; empty unless state is kFault
};

// Told that a device has failed between two calls, on a thread of the device's own; its info() says why.
using FaultListener = std::function<void()>;

// A laser rangefinder. Lives on the device thread. Errors are DeviceError or TimeoutError; after one the device is kFault
// until Reset succeeds.
class Rangefinder {
 public:
  virtual ~Rangefinder() = default;
  virtual DeviceInfo info() const = 0;
  // Size, projection and noise of the images it takes, by its own account.
  virtual SensorModel sensor_model() const = 0;
  // Makes ready to take images: allocates, starts the stream, waits for triggers.
  virtual void Arm() = 0;
  // Triggers by software (drivers with a trigger wire let Lines::PulseTrigger do it; then this does nothing).
  virtual void Trigger() = 0;
  // The next whole image: waits until `timeout`. Throws TimeoutError, DeviceError (naming the rule a frame broke), Cancelled.
  virtual Exposure Read(std::chrono::milliseconds timeout, std::stop_token stop) = 0;
  // Ends the stream; safe in any state, never throws.
  virtual void Disarm() noexcept = 0;
  // Brings a faulted or replugged device back to kIdle. Throws if it cannot.
  virtual void Reset() = 0;
  // Whom to tell of failures between calls; nullptr: nobody. A device that finds out only when it is called tells nobody.
  virtual void OnFault(FaultListener /*listener*/) {}
};

}  // namespace geond::drivers
