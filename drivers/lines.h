// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "drivers/rangefinder.h"

namespace geond::drivers {

// The wires of the station. The only device interface that is safe to call from any thread, so that a stop never waits
// its turn.
class Lines {
 public:
  struct Inputs {
    bool emergency_stop = false;  // pressed
    bool door_open = false;
  };
  virtual ~Lines() = default;
  virtual DeviceInfo info() const = 0;
  virtual void SetLaser(bool on) = 0;
  virtual void SetMotor(bool on) = 0;
  virtual void SetLamp(bool on) = 0;
  virtual bool laser() const = 0;
  virtual bool motor() const = 0;
  // One pulse on the trigger wire, of the configured width.
  virtual void PulseTrigger() = 0;
  virtual Inputs inputs() = 0;
  // Becomes readable when an input changes, for the I/O thread to wait on; -1 if the wires cannot say so.
  virtual int event_fd() const = 0;
  // Reads the waiting events (call when event_fd is readable) and returns the inputs as they are now.
  virtual Inputs ReadEvents() = 0;
  // Laser and motor off; safe in any state, never throws.
  virtual void AllOff() noexcept = 0;
};

}  // namespace geond::drivers
