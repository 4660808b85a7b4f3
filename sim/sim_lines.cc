// SPDX-License-Identifier: Apache-2.0
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "sim/sim_devices.h"

namespace geond::sim {
namespace {

constexpr char kName[] = "lines (simulated)";
constexpr std::chrono::milliseconds kSlow(500);
constexpr std::chrono::milliseconds kLate(1000);

}  // namespace

SimLines::SimLines(std::shared_ptr<SimStation> station) : station_(std::move(station)) {
  event_fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (event_fd_ < 0) throw DeviceError(kName, "open", std::strerror(errno));
  seen_ = {station_->emergency_stop(), station_->door_open()};
  station_->OnInputChange([this] {
    if (station_->fault(Device::kLines) == Fault::kDelayed) {
      station_->Schedule(kLate, [this] { Notice(); });
    } else {
      Notice();
    }
  });
}

SimLines::~SimLines() {
  AllOff();
  station_->OnInputChange(nullptr);
  close(event_fd_);
}

void SimLines::Notice() {
  const Fault fault = station_->fault(Device::kLines);
  if (fault == Fault::kStuck || fault == Fault::kOff) return;
  const std::lock_guard lock(mutex_);
  seen_ = {station_->emergency_stop(), station_->door_open()};
  eventfd_write(event_fd_, 1);
}

drivers::DeviceInfo SimLines::info() const {
  using drivers::DeviceState;
  const Fault fault = station_->fault(Device::kLines);
  const bool on = station_->laser_line() || station_->motor_line();
  const DeviceState state = fault == Fault::kOff ? DeviceState::kAbsent : on ? DeviceState::kArmed : DeviceState::kIdle;
  return {"lines", "simulated", "geond wires", "SIM-LINES-1", state, ""};
}

Fault SimLines::Call(const char* call) {
  const Fault fault = station_->fault(Device::kLines);
  std::uint64_t number;
  {
    const std::lock_guard lock(mutex_);
    number = ++calls_;
  }
  if (fault == Fault::kOff) throw DeviceError(kName, call, "the chip is gone", "Check its cable and power");
  if (fault == Fault::kIntermittent && number % 2 == 1) {
    throw DeviceError(kName, call, "the request failed", "Check the plugs");
  }
  if (fault == Fault::kSlow) station_->Advance(kSlow);
  return fault;
}

void SimLines::Set(const char* call, bool on, void (SimStation::*set)(bool), bool (SimStation::*get)() const) {
  const Fault fault = Call(call);
  if (fault != Fault::kStuck) (*station_.*set)(on);
  if ((*station_.*get)() != on) {
    throw DeviceError(kName, call,
                      std::string("the wire was set ") + (on ? "on" : "off") + " but reads " + (on ? "off" : "on"),
                      "Check the wiring");
  }
}

void SimLines::SetLaser(bool on) { Set("set laser", on, &SimStation::SetLaserLine, &SimStation::laser_line); }
void SimLines::SetMotor(bool on) { Set("set motor", on, &SimStation::SetMotorLine, &SimStation::motor_line); }
void SimLines::SetLamp(bool on) { Set("set lamp", on, &SimStation::SetLampLine, &SimStation::lamp_line); }
bool SimLines::laser() const { return station_->laser_line(); }
bool SimLines::motor() const { return station_->motor_line(); }

void SimLines::PulseTrigger() {
  if (Call("pulse trigger") != Fault::kStuck) station_->PulseTrigger();
}

drivers::Lines::Inputs SimLines::Seen(const char* call) {
  const Fault fault = Call(call);
  if (fault == Fault::kGarbage) {
    throw DeviceError(kName, call, "the inputs change faster than any switch does", "Check the wiring of the inputs");
  }
  if (fault != Fault::kStuck && fault != Fault::kDelayed) {
    const std::lock_guard lock(mutex_);
    seen_ = {station_->emergency_stop(), station_->door_open()};
  }
  const std::lock_guard lock(mutex_);
  return fault == Fault::kWrong ? Inputs{!seen_.emergency_stop, !seen_.door_open} : seen_;
}

drivers::Lines::Inputs SimLines::inputs() { return Seen("read inputs"); }

drivers::Lines::Inputs SimLines::ReadEvents() {
  eventfd_t count;
  eventfd_read(event_fd_, &count);
  return Seen("read events");
}

void SimLines::AllOff() noexcept {
  if (station_->fault(Device::kLines) == Fault::kStuck) return;
  station_->SetLaserLine(false);
  station_->SetMotorLine(false);
}

}  // namespace geond::sim
