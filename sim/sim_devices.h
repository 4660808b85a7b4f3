// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "drivers/lines.h"
#include "drivers/rangefinder.h"
#include "drivers/turntable.h"
#include "sim/sim_station.h"

namespace geond::sim {

// The simulated rangefinder. A frame comes `exposure_time` after a trigger, if the device is armed and the laser shines
// all the while. Faults: off: no call is answered. stuck: no frame ever comes. garbage: frames of random bits. wrong:
// frames of half the rows. slow: a frame takes 20 exposure times. delayed: it comes a second after the deadline and is
// dropped as stale. intermittent: every second frame is lost.
class SimRangefinder : public drivers::Rangefinder {
 public:
  enum class TriggerSource { kSoftware, kWire };
  explicit SimRangefinder(std::shared_ptr<SimStation> station, TriggerSource source = TriggerSource::kSoftware);
  ~SimRangefinder() override;

  drivers::DeviceInfo info() const override;
  SensorModel sensor_model() const override;
  void Arm() override;
  void Trigger() override;
  Exposure Read(std::chrono::milliseconds timeout, std::stop_token stop) override;
  void Disarm() noexcept override;
  void Reset() override;

 private:
  void CheckAnswers(const char* call);
  [[noreturn]] void FailRead(const std::string& cause, bool timeout);
  std::uint64_t triggers() const;

  const std::shared_ptr<SimStation> station_;
  const TriggerSource source_;
  mutable std::mutex mutex_;  // of state_ and fault_text_: info() may come from another thread
  drivers::DeviceState state_ = drivers::DeviceState::kIdle;
  std::string fault_text_;
  std::uint64_t software_triggers_ = 0, used_triggers_ = 0, frames_ = 0;
  SimStation::Time software_trigger_time_{0};
};

// The simulated drive and table. Faults: off: no reply, and the table stands. stuck: the motor does not turn. garbage:
// replies with a wrong checksum. wrong: it loses steps and stands 10 degrees off. slow: a twentieth of the speed.
// delayed: replies come a second late. intermittent: every third request goes unanswered.
class SimTurntable : public drivers::Turntable {
 public:
  explicit SimTurntable(std::shared_ptr<SimStation> station);
  ~SimTurntable() override;

  drivers::DeviceInfo info() const override;
  void Enable() override;
  void Home(std::stop_token stop) override;
  void MoveTo(double angle, std::stop_token stop) override;
  double angle() override;
  bool moving() override;
  void Halt() noexcept override;
  void Disable() noexcept override;
  void Reset() override;

 private:
  void Exchange(const std::string& call);  // one request and its reply
  [[noreturn]] void Fail(const std::string& call, const std::string& cause, const std::string& remedy, bool timeout);
  void Run(const std::string& call, double target, std::stop_token stop);

  const std::shared_ptr<SimStation> station_;
  mutable std::mutex mutex_;
  drivers::DeviceState state_ = drivers::DeviceState::kIdle;
  std::string fault_text_;
  bool homed_ = false;
  std::uint64_t requests_ = 0;
  std::atomic<std::uint64_t> halts_{0};
};

// The simulated wires. Faults: off: the chip is gone, outputs fall, calls fail. stuck: outputs and inputs stay as they
// are. garbage: inputs chatter. wrong: inputs are read inverted. slow: a call takes half a second. delayed: a change of
// an input is seen a second late. intermittent: every second call fails.
class SimLines : public drivers::Lines {
 public:
  explicit SimLines(std::shared_ptr<SimStation> station);
  ~SimLines() override;

  drivers::DeviceInfo info() const override;
  void SetLaser(bool on) override;
  void SetMotor(bool on) override;
  void SetLamp(bool on) override;
  bool laser() const override;
  bool motor() const override;
  void PulseTrigger() override;
  Inputs inputs() override;
  int event_fd() const override { return event_fd_; }
  Inputs ReadEvents() override;
  void AllOff() noexcept override;

 private:
  Fault Call(const char* call);  // the fault now, after failing or waiting as it wants
  void Set(const char* call, bool on, void (SimStation::*set)(bool), bool (SimStation::*get)() const);
  void Notice();
  Inputs Seen(const char* call);

  const std::shared_ptr<SimStation> station_;
  int event_fd_ = -1;
  mutable std::mutex mutex_;
  Inputs seen_;
  std::uint64_t calls_ = 0;
};

// Throws DeviceError naming the rule broken if an image is no frame of this sensor: size, finite depths within range.
void CheckFrame(const RangeImage& image, const SensorModel& sensor, const std::string& device);

}  // namespace geond::sim
