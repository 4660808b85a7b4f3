// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/base/printed.h"
#include "sim/sim_devices.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using std::chrono::milliseconds;

constexpr char kName[] = "turntable (simulated)";
constexpr milliseconds kTick(2);
constexpr milliseconds kLate(1000);
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kInPosition = 0.0035;  // rad (0.2 degrees)
constexpr double kLostSteps = kTwoPi / 36.0;
constexpr double kSlowness = 20.0;

std::string Degrees(double angle) { return Printed("%.2f degrees", angle * 360.0 / kTwoPi); }

}  // namespace

SimTurntable::SimTurntable(std::shared_ptr<SimStation> station) : station_(std::move(station)) {}

SimTurntable::~SimTurntable() { Disable(); }

drivers::DeviceInfo SimTurntable::info() const {
  const std::lock_guard lock(mutex_);
  const bool absent = station_->fault(Device::kTurntable) == Fault::kOff;
  return {"turntable", "simulated", "geond turntable", "SIM-TABLE-1", absent ? DeviceState::kAbsent : state_,
          fault_text_};
}

void SimTurntable::Fail(const std::string& call, const std::string& cause, const std::string& remedy, bool timeout) {
  station_->StopTable();
  {
    const std::lock_guard lock(mutex_);
    state_ = DeviceState::kFault;
    fault_text_ = cause;
  }
  if (timeout) throw TimeoutError(kName, call, cause, remedy);
  throw DeviceError(kName, call, cause, remedy);
}

void SimTurntable::Exchange(const std::string& call) {
  std::uint64_t request;
  {
    const std::lock_guard lock(mutex_);
    request = ++requests_;
  }
  switch (station_->fault(Device::kTurntable)) {
    case Fault::kOff:
      Fail(call, "the drive does not answer", "Switch it on and check its cable", false);
    case Fault::kGarbage:
      Fail(call, "the reply's checksum is wrong", "Check cable, speed and parity of the serial line", false);
    case Fault::kDelayed:
      station_->Advance(kLate);
      Fail(call, "no reply came within " + std::to_string(kLate.count()) + " ms", "Check the load on the bus", true);
    case Fault::kIntermittent:
      if (request % 3 == 0) Fail(call, "a request went unanswered", "Check the plugs of the bus cable", false);
      break;
    default:
      break;
  }
  station_->Advance(station_->options().reply_time);
}

void SimTurntable::Enable() {
  Exchange("enable");
  if (!station_->motor_powered()) {
    throw DeviceError(kName, "enable", "the motor has no power",
                      "Release the emergency stop and switch the motor-enable line on");
  }
  const std::lock_guard lock(mutex_);
  if (state_ == DeviceState::kFault)
    throw DeviceError(kName, "enable", "it is in fault: " + fault_text_, "Reset it first");
  state_ = DeviceState::kArmed;
}

// Moves and waits until the table stands, watching power, stop requests and the time.
void SimTurntable::Run(const std::string& call, double target, std::stop_token stop) {
  const StationOptions& options = station_->options();
  const std::uint64_t halts = halts_.load();
  const double start = station_->motor_angle();
  const SimStation::Time begin = station_->now();
  const double expected = TurntableMotion::Duration(options.turntable, target - start);
  const auto limit = std::min<SimStation::Time>(
      options.motion_time_limit, std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * (1.5 * expected + 0.5))));
  const Fault fault = station_->fault(Device::kTurntable);
  if (fault == Fault::kWrong) target += kLostSteps;
  if (fault != Fault::kStuck && fault != Fault::kSlow) station_->MoveTable(target);
  while (true) {
    station_->Advance(kTick);
    if (stop.stop_requested() || halts_.load() != halts) {
      station_->StopTable();
      while (station_->table_moving()) station_->Advance(kTick);
      if (stop.stop_requested()) throw Cancelled();
      throw DeviceError(kName, call, "it was halted at " + Degrees(station_->motor_angle()));
    }
    if (station_->fault(Device::kTurntable) == Fault::kOff) Exchange(call);  // throws
    if (!station_->motor_powered()) {
      Fail(call, "the motor lost its power at " + Degrees(station_->motor_angle()),
           "Release the emergency stop, switch the motor-enable line on and reset the turntable", false);
    }
    const double passed = std::chrono::duration<double>(station_->now() - begin).count();
    if (fault == Fault::kSlow) {
      const double share = expected > 0.0 ? std::min(1.0, passed / (kSlowness * expected)) : 1.0;
      station_->MoveTable(start + share * (target - start));
      if (share >= 1.0 && !station_->table_moving()) return;
    } else if (fault != Fault::kStuck && !station_->table_moving()) {
      return;
    } else if (fault == Fault::kStuck && std::abs(target - start) < kInPosition) {
      return;
    }
    if (station_->now() - begin > limit) {
      Fail(call, "it stands at " + Degrees(station_->motor_angle()) + " and did not arrive in time",
           "Check that nothing blocks the table, then reset it", true);
    }
  }
}

void SimTurntable::Home(std::stop_token stop) {
  Exchange("home");
  {
    const std::lock_guard lock(mutex_);
    if (state_ != DeviceState::kArmed) throw DeviceError(kName, "home", "it is not enabled", "Enable it first");
  }
  const SimStation::Time end = station_->now() + station_->options().homing_time;
  while (station_->now() < end && !stop.stop_requested()) station_->Advance(kTick);
  const double start = station_->motor_angle();
  Run("home", start - std::remainder(start, kTwoPi), stop);  // the next zero, however often the table has turned
  const std::lock_guard lock(mutex_);
  homed_ = true;
}

void SimTurntable::MoveTo(double angle, std::stop_token stop) {
  if (!std::isfinite(angle)) throw std::invalid_argument("SimTurntable::MoveTo: the angle is not finite");
  const std::string call = "move to " + Degrees(angle);
  Exchange(call);
  {
    const std::lock_guard lock(mutex_);
    if (state_ != DeviceState::kArmed) throw DeviceError(kName, call, "it is not enabled", "Enable it first");
    if (!homed_) throw DeviceError(kName, call, "its zero is not known", "Home it first");
  }
  const double start = station_->motor_angle();
  Run(call, start + std::remainder(angle - start, kTwoPi), stop);
  const double stands = this->angle();
  if (std::abs(std::remainder(stands - angle, kTwoPi)) > kInPosition) {
    Fail(call, "it says it has arrived but stands at " + Degrees(stands), "Reset and home it", false);
  }
}

double SimTurntable::angle() {
  Exchange("read angle");
  return std::remainder(station_->ReadAngle(), kTwoPi);
}

bool SimTurntable::moving() {
  Exchange("read state");
  return station_->table_moving();
}

void SimTurntable::Halt() noexcept {
  ++halts_;
  station_->StopTable();
}

void SimTurntable::Disable() noexcept {
  station_->StopTable();
  const std::lock_guard lock(mutex_);
  if (state_ == DeviceState::kArmed) state_ = DeviceState::kIdle;
}

void SimTurntable::Reset() {
  Exchange("reset");
  const std::lock_guard lock(mutex_);
  state_ = DeviceState::kIdle;
  fault_text_.clear();
  homed_ = false;  // what happened to the table meanwhile is not known
}

}  // namespace geond::sim
