// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "drivers/rangefinder.h"

namespace geond::drivers {

// A motor-driven table. Lives on the device thread, but for Halt. Angles in rad, counter-clockwise seen from above.
class Turntable {
 public:
  virtual ~Turntable() = default;
  virtual DeviceInfo info() const = 0;
  virtual void Enable() = 0;
  // Finds the zero. Throws TimeoutError, DeviceError, Cancelled (then the table stands).
  virtual void Home(std::stop_token stop) = 0;
  // Moves to an angle the shortest way round and waits until it stands there within tolerance.
  virtual void MoveTo(double angle, std::stop_token stop) = 0;
  // As read from the device now.
  virtual double angle() = 0;
  virtual bool moving() = 0;
  // Stops at once; safe from any thread, in any state, never throws.
  virtual void Halt() noexcept = 0;
  virtual void Disable() noexcept = 0;
  // Clears the drive's alarm after its cause is gone. Throws if it stays.
  virtual void Reset() = 0;
  // As Rangefinder::OnFault.
  virtual void OnFault(FaultListener /*listener*/) {}
};

}  // namespace geond::drivers
