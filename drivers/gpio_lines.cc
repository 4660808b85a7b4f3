// SPDX-License-Identifier: Apache-2.0
#include "drivers/gpio_lines.h"

#include <fcntl.h>
#include <gpiod.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

constexpr char kName[] = "lines (gpio)";
constexpr char kConsumer[] = "geond";
using Clock = std::chrono::steady_clock;

int RequestFlags(const GpioWire& wire) {
  int flags = wire.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  switch (wire.bias) {
    case GpioWire::Bias::kAsIs: break;
    case GpioWire::Bias::kNone: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE; break;
    case GpioWire::Bias::kPullUp: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP; break;
    case GpioWire::Bias::kPullDown: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN; break;
  }
  return flags;
}

std::string Remedy(int error) {
  switch (error) {
    case EACCES:
    case EPERM: return "Let this user open the chip: install geond's udev rule and add the user to the group gpio";
    case EBUSY: return "Another program holds the line: see gpioinfo";
    case ENOENT:
    case ENODEV: return "Check the chip's name with gpiodetect, its cable and its power";
    case EINVAL: return "Check the line's number and bias: see gpioinfo";
    default: return "Check the chip and its cable";
  }
}

}  // namespace

std::string WireWords(const char* name, const GpioWire& wire) {
  return std::string(name) + ", line " + (wire.line.empty() ? std::to_string(wire.offset) : wire.line) + " of " + wire.chip;
}

void GpioLines::CloseChip::operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }

GpioLines::GpioLines(GpioLinesOptions options) : options_(std::move(options)) {
  laser_.where = options_.laser;
  emergency_stop_.where = options_.emergency_stop;
  motor_.where = options_.motor;
  lamp_.where = options_.lamp;
  trigger_.where = options_.trigger;
  door_.where = options_.door;
  const std::array wires = {&laser_, &motor_, &lamp_, &trigger_, &emergency_stop_, &door_};
  for (const Wire* a : wires) {
    for (const Wire* b : wires) {
      if (a < b && a->where && b->where && a->where->chip == b->where->chip && a->where->line == b->where->line &&
          (!a->where->line.empty() || a->where->offset == b->where->offset)) {
        throw std::invalid_argument(std::string("gpio lines: ") + a->name + " and " + b->name +
                                    " are on the same line");
      }
    }
  }
  event_fd_ = epoll_create1(EPOLL_CLOEXEC);
  timer_fd_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  epoll_event event{};
  event.events = EPOLLIN;
  if (event_fd_ < 0 || timer_fd_ < 0 || epoll_ctl(event_fd_, EPOLL_CTL_ADD, timer_fd_, &event) != 0) {
    const int error = errno;
    if (event_fd_ >= 0) close(event_fd_);
    if (timer_fd_ >= 0) close(timer_fd_);
    throw DeviceError(kName, "open", std::strerror(error));
  }
  try {
    Open();
  } catch (...) {
    Release();
    if (options_.may_be_absent) return;  // fault_ says why
    close(timer_fd_);
    close(event_fd_);
    throw;
  }
}

GpioLines::~GpioLines() {
  AllOff();
  Release();
  close(timer_fd_);
  close(event_fd_);
}

void GpioLines::Fail(const char* call, const Wire& wire, int error) {
  fault_ = std::string(wire.name) + ": " + std::strerror(error);
  throw DeviceError(kName, call,
                    WireWords(wire.name, *wire.where) + ": " + std::strerror(error),
                    Remedy(error));
}

gpiod_chip* GpioLines::Chip(const std::string& name) {
  for (const auto& [known, chip] : chips_) {
    if (known == name) return chip.get();
  }
  gpiod_chip* chip = name.starts_with('/') ? gpiod_chip_open(name.c_str()) : gpiod_chip_open_lookup(name.c_str());
  if (chip != nullptr) chips_.emplace_back(name, chip);
  return chip;
}

void GpioLines::Request(Wire& wire, bool output) {
  if (!wire.where) return;
  gpiod_chip* chip = Chip(wire.where->chip);
  if (chip == nullptr) Fail("open chip", wire, errno);
  gpiod_line* line = wire.where->line.empty() ? gpiod_chip_get_line(chip, wire.where->offset)
                                              : gpiod_chip_find_line(chip, wire.where->line.c_str());
  if (line == nullptr) Fail("get line", wire, wire.where->line.empty() ? errno : EINVAL);
  const int flags = RequestFlags(*wire.where);
  const int result = output ? gpiod_line_request_output_flags(line, kConsumer, flags, 0)
                            : gpiod_line_request_both_edges_events_flags(line, kConsumer, flags);
  if (result != 0) Fail("request line", wire, errno);
  wire.line = line;
  wire.on = false;
  if (output) return;
  const int fd = gpiod_line_event_get_fd(line);
  epoll_event event{};
  event.events = EPOLLIN;
  if (fd < 0 || fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK) != 0 ||
      epoll_ctl(event_fd_, EPOLL_CTL_ADD, fd, &event) != 0) {
    Fail("watch line", wire, errno);
  }
}

void GpioLines::Open() {
  for (Wire* wire : {&laser_, &motor_, &lamp_, &trigger_}) Request(*wire, true);
  for (Wire* wire : {&emergency_stop_, &door_}) Request(*wire, false);
  // Levels after the requests: an edge may have come before them.
  for (Wire* wire : {&emergency_stop_, &door_}) ReadInput(*wire);
  fault_.clear();
  slow_ = false;
}

void GpioLines::Release() noexcept {
  for (Wire* wire : {&laser_, &motor_, &lamp_, &trigger_, &emergency_stop_, &door_}) {
    if (wire->line != nullptr) gpiod_line_release(wire->line);
    wire->line = nullptr;
    wire->on = false;
  }
  chips_.clear();
}

DeviceInfo GpioLines::info() const {
  const std::lock_guard lock(mutex_);
  DeviceInfo info{"lines", "gpio", "GPIO lines", options_.laser.chip, DeviceState::kIdle, fault_};
  if (!chips_.empty()) info.model = gpiod_chip_label(chips_.front().second.get());
  if (!fault_.empty()) {
    info.state = laser_.line == nullptr ? DeviceState::kAbsent : DeviceState::kFault;
  } else if (laser_.on || motor_.on) {
    info.state = DeviceState::kArmed;
  }
  return info;
}

void GpioLines::Drive(Wire& wire, const char* call, bool on) {
  if (wire.line == nullptr) Fail(call, wire, ENODEV);
  const Clock::time_point begin = Clock::now();
  if (gpiod_line_set_value(wire.line, on) != 0) Fail(call, wire, errno);
  wire.on = on;
  CheckPace(call, wire, begin);
}

// A chip on a bus that hangs must not keep the laser on: what is slow is let go.
void GpioLines::CheckPace(const char* call, const Wire& wire, Clock::time_point begin) {
  const auto took = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
  if (took <= options_.longest_call) return;
  slow_ = true;
  fault_ = std::string(wire.name) + " took " + std::to_string(took.count()) + " ms";
  throw DeviceError(kName, call, WireWords(wire.name, *wire.where) + ": the chip took " + std::to_string(took.count()) + " ms",
                    "Check the bus that the chip is on");
}

void GpioLines::Set(Wire& wire, const char* call, bool on) {
  const std::lock_guard lock(mutex_);
  if (!wire.where) {
    wire.on = on;
    return;
  }
  if (on && !fault_.empty()) {
    throw DeviceError(kName, call, "the lines failed before (" + fault_ + ")", "Reset the station");
  }
  Drive(wire, call, on);
  const int level = gpiod_line_get_value(wire.line);
  if (level < 0) Fail(call, wire, errno);
  if ((level != 0) != on) {
    fault_ = std::string(wire.name) + " does not follow";
    throw DeviceError(kName, call,
                      std::string(wire.name) + " was set " + (on ? "on" : "off") + " but reads " + (on ? "off" : "on"),
                      "Check the wiring");
  }
}

void GpioLines::SetLaser(bool on) { Set(laser_, "set laser", on); }
void GpioLines::SetMotor(bool on) { Set(motor_, "set motor", on); }
void GpioLines::SetLamp(bool on) { Set(lamp_, "set lamp", on); }

void GpioLines::PulseTrigger() {
  if (!trigger_.where) {
    throw DeviceError(kName, "pulse trigger", "no trigger wire is configured", "Name its line or trigger by software");
  }
  const std::lock_guard one_pulse(trigger_mutex_);
  {
    const std::lock_guard lock(mutex_);
    Drive(trigger_, "pulse trigger", true);
  }
  std::this_thread::sleep_for(options_.trigger_pulse);
  const std::lock_guard lock(mutex_);
  Drive(trigger_, "pulse trigger", false);
}

void GpioLines::ReadInput(Wire& wire) {
  if (!wire.where) return;
  if (wire.line == nullptr) Fail("read line", wire, ENODEV);
  bool active = false;
  const Clock::time_point begin = Clock::now();
  std::array<gpiod_line_event, 16> events;
  while (true) {
    const int count = gpiod_line_event_read_multiple(wire.line, events.data(), events.size());
    if (count < 0 && errno != EAGAIN) Fail("read events", wire, errno);
    if (count <= 0) break;
    active = true;  // any edge means that it was on for a moment
  }
  const int level = gpiod_line_get_value(wire.line);
  if (level < 0) Fail("read line", wire, errno);
  CheckPace("read line", wire, begin);
  if (level > 0 || active) {
    wire.on = true;
    wire.active = Clock::now();
  } else if (Clock::now() - wire.active >= options_.debounce) {
    wire.on = false;
  }
  // While it is on but its level is not, nothing will come from the line itself when the debounce time is over.
  if (wire.on && level == 0) ArmTimer();
}

void GpioLines::ArmTimer() {
  itimerspec time{};
  const auto wait = std::max<std::chrono::nanoseconds>(options_.debounce, std::chrono::nanoseconds(1));
  time.it_value.tv_sec = wait.count() / 1'000'000'000;
  time.it_value.tv_nsec = wait.count() % 1'000'000'000;
  timerfd_settime(timer_fd_, 0, &time, nullptr);
}

Lines::Inputs GpioLines::ReadAll(const char* call) {
  const std::lock_guard lock(mutex_);
  try {
    if (!fault_.empty()) {
      Release();
      Open();
    }
    ReadInput(emergency_stop_);
    ReadInput(door_);
  } catch (const DeviceError& error) {
    // What cannot be read may be pressed: let all outputs go.
    Release();
    throw DeviceError(kName, call, error.cause(), error.remedy());
  }
  return {emergency_stop_.on, door_.on};
}

Lines::Inputs GpioLines::inputs() { return ReadAll("read inputs"); }

Lines::Inputs GpioLines::ReadEvents() {
  std::uint64_t expirations = 0;
  while (read(timer_fd_, &expirations, sizeof expirations) > 0) {
  }
  return ReadAll("read events");
}

void GpioLines::AllOff() noexcept {
  const std::lock_guard lock(mutex_);
  for (Wire* wire : {&laser_, &motor_}) {
    wire->on = false;
    if (wire->line == nullptr) continue;
    const Clock::time_point begin = Clock::now();
    const bool failed = slow_ || gpiod_line_set_value(wire->line, 0) != 0 || gpiod_line_get_value(wire->line) != 0;
    slow_ = slow_ || Clock::now() - begin > options_.longest_call;
    if (failed) {
      // A line let go falls back to its safe level where the hardware is wired for it: the last resort.
      fault_ = std::string(wire->name) + " could not be switched off";
      gpiod_line_release(wire->line);
      wire->line = nullptr;
    }
  }
}

}  // namespace geond::drivers
