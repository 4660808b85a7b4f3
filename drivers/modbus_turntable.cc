// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus_turntable.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace geond::drivers {

ModbusTurntable::ModbusTurntable(ModbusTurntableOptions options)
    : options_(std::move(options)), link_("turntable", options_.address, options_.profile.status.address) {
  if (options_.gear_ratio == 0.0 || !(options_.speed > 0.0) || !(options_.acceleration > 0.0)) {
    throw std::invalid_argument("ModbusTurntable: gear ratio, speed and acceleration must not be zero");
  }
  info_.name = "turntable";
  info_.driver = "modbus";
  info_.model = options_.profile.name;
  info_.serial = options_.address.serial_device.empty() ? options_.address.host + ":" + std::to_string(options_.address.port)
                                                        : options_.address.serial_device;
}

ModbusTurntable::~ModbusTurntable() {
  if (link_.connected()) Disable();
  keep_alive_ = {};
}

DeviceInfo ModbusTurntable::info() const {
  const std::lock_guard lock(state_mutex_);
  return info_;
}

// Runs a call on the link; whatever fails leaves the device faulted, with the reason.
template <typename Work>
void ModbusTurntable::Guarded(const std::string& call, const Work& work) {
  try {
    if (const std::string fault = info().fault; !fault.empty()) {
      throw DeviceError("turntable", call, "it failed before: " + fault, "Reset it first");
    }
    work();
  } catch (const Error& error) {
    const std::lock_guard lock(state_mutex_);
    if (info_.fault.empty()) info_.fault = error.what();
    info_.state = link_.connected() ? DeviceState::kFault : DeviceState::kAbsent;
    throw;
  }
}

void ModbusTurntable::Enable() {
  Guarded("enable", [&] {
    halted_ = false;
    SetCommunicationTimeout();
    RunSequence("enable", {}, {});
    {
      const std::lock_guard lock(state_mutex_);
      info_.state = DeviceState::kArmed;
    }
    keep_alive_ = std::jthread([this](std::stop_token stop) { KeepAlive(stop); });
  });
}

void ModbusTurntable::Home(std::stop_token stop) {
  Guarded("home", [&] {
    halted_ = false;
    RunSequence("home", {}, stop);
  });
}

void ModbusTurntable::MoveTo(double target_angle, std::stop_token stop) {
  Guarded("move", [&] {
    halted_ = false;
    const DriveProfile& profile = options_.profile;
    const double now = angle();
    const double turn = std::remainder(target_angle - now, 2.0 * std::numbers::pi);
    const double target = now + turn;
    if (target < options_.min_angle || target > options_.max_angle) {
      throw std::invalid_argument("turntable: the target is beyond its soft limits");
    }
    const double step_rate = options_.speed * std::abs(steps_per_radian());
    const double step_acceleration = options_.acceleration * std::abs(steps_per_radian());
    const double thousand_rpm = 1000.0 / 60.0 * profile.steps_per_turn;  // steps a second
    const double accel = profile.accel_factor * (profile.accel == DriveProfile::Accel::kRate   ? step_acceleration
                                                 : profile.accel == DriveProfile::Accel::kTime ? 1e3 * step_rate / step_acceleration
                                                                                               : 1e3 * thousand_rpm / step_acceleration);
    const std::int64_t target_steps = std::llround(target * steps_per_radian());
    const Values values{{"target", target_steps},
                        {"speed", std::max<std::int64_t>(1, std::llround(step_rate * profile.speed_factor))},
                        {"accel", std::llround(accel)},
                        {"decel", std::llround(accel)},
                        {"lifetime_ms", profile.lifetime.count()}};
    RunSequence("move", values, stop);

    const Clock::time_point begin = Clock::now();
    const double expected = std::abs(turn) / options_.speed + options_.speed / options_.acceleration;  // s
    const auto limit = options_.motion_timeout + std::chrono::milliseconds(std::llround(1.5e3 * expected));
    Clock::time_point repeated = begin;
    Stall stall;
    const double tolerance = std::max(1.0, options_.tolerance * std::abs(steps_per_radian()));
    for (;;) {
      Pause(options_.poll_period, stop, "move");
      const std::uint32_t status = CheckedStatus("move");
      const bool there = std::abs(static_cast<double>(ReadRegister(profile.position) - target_steps)) <= tolerance;
      if (there && !(status & profile.moving) && (!profile.in_position || (status & profile.in_position))) break;
      CheckStall(stall, "move");
      const Clock::time_point time = Clock::now();
      if (time - begin > limit) {
        Halt();
        throw TimeoutError("turntable", "move", "not in position after " + std::to_string(limit.count()) + " ms",
                           "Is something in its way?");
      }
      if (profile.lifetime.count() > 0 && time - repeated > profile.lifetime / 3) {
        RunSequence("move", values, stop);
        repeated = time;
      }
    }
    Pause(options_.settle_time, stop, "move");
  });
}

double ModbusTurntable::angle() {
  return static_cast<double>(ReadRegister(options_.profile.position)) / steps_per_radian();
}

bool ModbusTurntable::moving() { return ReadRegister(options_.profile.status) & options_.profile.moving; }

void ModbusTurntable::Halt() noexcept {
  halted_ = true;
  wake_.notify_all();
  WriteOnce("quick_stop");
}

void ModbusTurntable::WriteOnce(const std::string& sequence) noexcept {
  // If it fails, the motor-enable wire and the drive's own timeouts are what is left.
#if defined(__SANITIZE_THREAD__)  // gcc 12's does not see a lock that waits by the steady clock
  const std::unique_lock lock(link_mutex_, std::chrono::system_clock::now() + options_.address.response_timeout);
#else
  const std::unique_lock lock(link_mutex_, options_.address.response_timeout);
#endif
  if (!lock.owns_lock() || !link_.connected()) return;
  for (const DriveStep& step : options_.profile.sequences.at(sequence)) {
    if (step.kind == DriveStep::Kind::kWrite && !link_.WriteOnce(step.address, WordsOf(step, {}))) return;
  }
}

void ModbusTurntable::CheckStall(Stall& stall, const std::string& call) {
  const std::int64_t position = ReadRegister(options_.profile.position);
  if (position != stall.position) {
    stall = {position, Clock::now()};
  } else if (Clock::now() - stall.since > options_.stall_time) {
    Halt();
    throw DeviceError("turntable", call, "the motor does not turn", "Look for what blocks it and whether it has power");
  }
}

void ModbusTurntable::KeepAlive(std::stop_token stop) {
  const std::chrono::milliseconds own = options_.profile.communication_timeout_value / 4;
  const std::chrono::milliseconds period = own.count() > 0 ? std::min(own, options_.watch_period) : options_.watch_period;
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  while (!never.wait_for(lock, stop, period, [] { return false; }) && !stop.stop_requested()) {
    if (!info().fault.empty()) return;  // the call that failed has said so
    try {
      Guarded("keep the drive awake", [&] { CheckedStatus("keep the drive awake"); });
    } catch (const Error&) {
      signal_.Tell();  // the device is faulted and says why; the next call throws
      return;
    }
  }
}

void ModbusTurntable::Disable() noexcept {
  keep_alive_ = {};
  for (const char* name : {"quick_stop", "disable"}) WriteOnce(name);
  const std::lock_guard lock(state_mutex_);
  if (info_.state == DeviceState::kArmed) info_.state = DeviceState::kIdle;
}

void ModbusTurntable::Reset() {
  keep_alive_ = {};
  {
    const std::lock_guard lock(state_mutex_);
    info_.state = DeviceState::kIdle;
    info_.fault.clear();
  }
  Guarded("reset", [&] {
    halted_ = false;
    try {
      ReadRegister(options_.profile.status);
    } catch (const TimeoutError& error) {
      link_.Close();
      const std::string finding = FindLineSettings(options_.address, options_.profile.status.address);
      if (finding.empty()) throw;
      throw DeviceError("turntable", "reset", error.cause() + "; " + finding, "Correct turntable.baud and turntable.parity");
    }
    if (ReadRegister(options_.profile.status) & options_.profile.alarmed) RunSequence("reset", {}, {});
    CheckedStatus("reset");
  });
}

std::int64_t ModbusTurntable::ReadRegister(const DriveRegister& what) {
  const std::lock_guard lock(link_mutex_);
  const std::vector<std::uint16_t> words = link_.Read(what.address, what.words());
  if (what.type == DriveRegister::Type::kU16) return words[0];
  if (what.type == DriveRegister::Type::kI16) return static_cast<std::int16_t>(words[0]);
  const bool high_first = options_.profile.high_word_first;
  const std::uint32_t value = std::uint32_t{words[high_first ? 0 : 1]} << 16 | words[high_first ? 1 : 0];
  return what.type == DriveRegister::Type::kU32 ? std::int64_t{value} : std::int64_t{static_cast<std::int32_t>(value)};
}

std::vector<std::uint16_t> ModbusTurntable::WordsOf(const DriveStep& step, const Values& values) const {
  std::vector<std::uint16_t> words;
  for (const auto& [type, value] : step.values) {
    const std::int64_t number = std::holds_alternative<std::string>(value) ? values.at(std::get<std::string>(value))
                                                                           : std::get<std::int64_t>(value);
    const auto low = static_cast<std::uint16_t>(number & 0xffff), high = static_cast<std::uint16_t>(number >> 16 & 0xffff);
    if (type == DriveRegister::Type::kU16 || type == DriveRegister::Type::kI16) {
      words.push_back(low);
    } else {
      words.push_back(options_.profile.high_word_first ? high : low);
      words.push_back(options_.profile.high_word_first ? low : high);
    }
  }
  return words;
}

void ModbusTurntable::WriteStep(const DriveStep& step, const Values& values) {
  const std::lock_guard lock(link_mutex_);
  link_.Write(step.address, WordsOf(step, values));
}

void ModbusTurntable::RunSequence(const std::string& name, const Values& values, std::stop_token stop) {
  for (const DriveStep& step : options_.profile.sequences.at(name)) {
    if (step.kind == DriveStep::Kind::kWrite) {
      if (halted_) throw DeviceError("turntable", name, "it was halted", "Reset it first");
      WriteStep(step, values);
    } else {
      WaitForStatus(step, name, stop);
    }
  }
}

void ModbusTurntable::WaitForStatus(const DriveStep& step, const std::string& sequence, std::stop_token stop) {
  const Clock::time_point end = Clock::now() + step.timeout;
  Stall stall;
  const bool may_be_alarmed = sequence == "reset";
  for (;;) {
    const auto status = static_cast<std::uint32_t>(may_be_alarmed ? ReadRegister(options_.profile.status) : CheckedStatus(sequence));
    if ((status & step.mask) == step.equals) return;
    if (sequence == "home") CheckStall(stall, sequence);
    if (Clock::now() > end) {
      throw TimeoutError("turntable", sequence, "the drive did not report " + step.name + " within " +
                         std::to_string(step.timeout.count()) + " ms", "Look at the drive's display");
    }
    Pause(options_.poll_period, stop, sequence);
  }
}

std::uint32_t ModbusTurntable::CheckedStatus(const std::string& call) {
  const auto status = static_cast<std::uint32_t>(ReadRegister(options_.profile.status));
  if (status & options_.profile.alarmed) FailAlarm(call);
  return status;
}

void ModbusTurntable::FailAlarm(const std::string& call) {
  const auto code = static_cast<std::uint32_t>(ReadRegister(options_.profile.alarm)) & options_.profile.alarm_mask;
  const auto words = options_.profile.alarm_words.find(code);
  char number[16];
  std::snprintf(number, sizeof number, "%02Xh", code);
  throw DeviceError("turntable", call, "the drive's alarm " + std::string(number) +
                    (words == options_.profile.alarm_words.end() ? "" : " (" + words->second + ")"),
                    "Remove the cause, then reset");
}

void ModbusTurntable::Pause(std::chrono::milliseconds time, std::stop_token stop, const std::string& call) {
  {
    std::unique_lock lock(wake_mutex_);
    wake_.wait_for(lock, stop, time, [&] { return halted_.load(); });
  }
  if (halted_) throw DeviceError("turntable", call, "it was halted", "Reset it first");
  if (stop.stop_requested()) {
    Halt();
    throw Cancelled();
  }
}

void ModbusTurntable::SetCommunicationTimeout() {
  const DriveProfile& profile = options_.profile;
  if (profile.communication_timeout.address == 0) return;
  DriveStep step;
  step.address = profile.communication_timeout.address;
  step.values = {{profile.communication_timeout.type, profile.communication_timeout_value.count()}};
  WriteStep(step, {});
  const std::int64_t read_back = ReadRegister(profile.communication_timeout);
  if (read_back != profile.communication_timeout_value.count()) {
    throw DeviceError("turntable", "set the communication timeout", "the drive says " + std::to_string(read_back) + " ms where " +
                      std::to_string(profile.communication_timeout_value.count()) + " ms were written",
                      "Without it a dead service would not stop the table");
  }
}

double ModbusTurntable::steps_per_radian() const {
  return options_.profile.steps_per_turn * options_.gear_ratio / (2.0 * std::numbers::pi);
}

}  // namespace geond::drivers
