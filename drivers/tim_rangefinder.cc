// SPDX-License-Identifier: Apache-2.0
#include "drivers/tim_rangefinder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "drivers/usb_guard.h"

namespace geond::drivers {
namespace {

using cola::Protocol;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr char kName[] = "scanner";
constexpr std::size_t kReadSize = 64 << 10;
constexpr milliseconds kGlance(20);      // between looks at a stop request
constexpr milliseconds kAnswerToA(300);  // one that speaks CoLa-A answers sooner
constexpr std::uint32_t kCounterEnd = 1u << 16;
// SetAccessMode: authorised client and the hash of its published password.
constexpr std::array<std::uint8_t, 5> kAccess = {0x03, 0xf4, 0x72, 0x47, 0x44};
constexpr std::array<std::uint8_t, 1> kOn = {1}, kOff = {0};

}  // namespace

TimRangefinder::TimRangefinder(UsbOpener open, TimRangefinderOptions options)
    : open_(std::move(open)), options_(options), info_{"rangefinder", "tim", "", "", DeviceState::kAbsent, ""} {
  if (options.columns < 2 || options.lines < 1 || !(options.field > 0.0 && options.field < std::numbers::pi)) {
    throw std::invalid_argument("TimRangefinder: columns, lines or field are impossible");
  }
  sensor_.columns = options.columns;
  sensor_.rows = 1;
  sensor_.center_u = 0.5 * (options.columns - 1);
  sensor_.focal_u = sensor_.focal_v = sensor_.center_u / std::tan(0.5 * options.field);
  sensor_.min_depth = 0.05;
  sensor_.max_depth = 10.0;
  sensor_.depth_noise = options.depth_noise;
  Open();
}

TimRangefinder::~TimRangefinder() { Disarm(); }

DeviceInfo TimRangefinder::info() const {
  const std::lock_guard lock(info_mutex_);
  return info_;
}

void TimRangefinder::Fail(const char* call, const std::string& cause, const std::string& remedy) const {
  throw DeviceError(kName, call, cause, remedy);
}

std::optional<cola::Telegram> TimRangefinder::Next(Clock::time_point deadline, std::stop_token stop, const char* call) {
  std::array<std::uint8_t, kReadSize> buffer;
  while (true) {
    if (auto telegram = cola::TakeTelegram(received_, broken_)) return telegram;
    ThrowIfStopped(stop);
    const auto left = std::chrono::ceil<milliseconds>(deadline - port_->Now());
    if (left.count() <= 0) return std::nullopt;
    const UsbPort::Result result = port_->ControlIn(buffer, std::min(left, kGlance));
    if (result.status == UsbPort::Status::kStall) port_->ClearControlHalt();
    if (result.status == UsbPort::Status::kGone || result.status == UsbPort::Status::kFailed) {
      Fail(call, std::string(UsbStatusWords(result.status)), "Plug it in and reset the station");
    }
    received_.insert(received_.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(result.size));
  }
}

// `text` for CoLa-A has its numbers in it; for CoLa-B they are `binary`, after the first two words of the text.
cola::Telegram TimRangefinder::Ask(const std::string& text, cola::ByteView binary, const std::string& reply) {
  const std::size_t name_end = std::min(text.find(' ', std::min(text.find(' '), text.size() - 1) + 1), text.size());
  const std::string name = text.substr(0, name_end);
  const cola::Bytes command = protocol_ == Protocol::kA
                                  ? cola::Encode(protocol_, text)
                                  : cola::Encode(protocol_, binary.empty() ? name : name + " ", binary);
  const UsbPort::Result sent = port_->ControlOut(command, options_.response_time);
  if (sent.status != UsbPort::Status::kOk) {
    Fail(name.c_str(), std::string(UsbStatusWords(sent.status)), "Plug it in again and reset the station");
  }
  const Clock::time_point deadline = port_->Now() + options_.response_time;
  while (const auto telegram = Next(deadline, {}, name.c_str())) {
    if (const std::string refusal = cola::ErrorReply(*telegram); !refusal.empty())
      Fail(name.c_str(), refusal, "Check its firmware");
    const std::string said =
        std::string(telegram->kind()) + (telegram->name().empty() ? "" : " ") + std::string(telegram->name());
    if (said.starts_with(reply)) return *telegram;  // else a line or an answer that was still under way
  }
  throw TimeoutError(kName, name, "no answer within " + std::to_string(options_.response_time.count()) + " ms",
                     "Check the cable, or unplug the scanner and plug it in again");
}

void TimRangefinder::Open() {
  NotingFault(info_mutex_, info_, [this] {
    port_.reset();
    port_ = open_();
    received_.clear();
    protocol_ = Protocol::kA;
    const cola::Bytes who = cola::Encode(Protocol::kA, "sRN SCdevicestate");
    std::optional<cola::Telegram> answer;
    if (port_->ControlOut(who, options_.response_time).status == UsbPort::Status::kOk) {
      answer = Next(port_->Now() + std::min(options_.response_time, kAnswerToA), {}, "open");
    }
    if (!answer || answer->protocol == Protocol::kB) protocol_ = Protocol::kB;
    Ask("sEN LMDscandata 0", kOff, "sEA LMDscandata");  // whoever spoke to it before may have died
    Ask("sMN SetAccessMode 03 F4724744", kAccess, "sAN SetAccessMode");
    Ask("sMN Run", {}, "sAN Run");
  });
  const std::lock_guard lock(info_mutex_);
  info_ = {"rangefinder", "tim", port_->model(), port_->identity(), DeviceState::kIdle, ""};
}

void TimRangefinder::Arm() {
  if (const DeviceInfo now = info(); !now.fault.empty()) {
    throw DeviceError(kName, "arm", "it failed before: " + now.fault, "Reset the station");
  }
  NotingFault(info_mutex_, info_, [this] { Ask("sEN LMDscandata 1", kOn, "sEA LMDscandata"); });
  last_counter_.reset();
  const std::lock_guard lock(info_mutex_);
  info_.state = DeviceState::kArmed;
}

// Lines from before are no part of the next image.
void TimRangefinder::Trigger() {
  if (info().state != DeviceState::kArmed) throw DeviceError(kName, "trigger", "it is not armed", "Arm it first");
  NotingFault(info_mutex_, info_, [this] {
    const Clock::time_point deadline = port_->Now() + milliseconds(1);
    while (Next(deadline, {}, "trigger")) {
    }
  });
  last_counter_.reset();
}

// The nearest reading to each column's direction; a scanner's angles are even, a picture's columns are not.
void TimRangefinder::StoreLine(const cola::ScanLine& line, RangeImage& image) const {
  const double middle = line.first_angle + 0.5 * line.step * static_cast<double>(line.range.size() - 1);
  for (int column = 0; column < image.columns; ++column) {
    // Columns go to the right, angles to the left.
    const double angle = -std::atan((column - sensor_.center_u) / sensor_.focal_u);
    const double at = (middle + angle - line.first_angle) / line.step;
    float depth = std::numeric_limits<float>::quiet_NaN();
    if (at > -0.5 && at < static_cast<double>(line.range.size()) - 0.5) {
      depth = static_cast<float>(line.range[static_cast<std::size_t>(std::lround(at))] * std::cos(angle));
    }
    image.depth.push_back(depth);
  }
  ++image.rows;
}

Exposure TimRangefinder::Read(milliseconds timeout, std::stop_token stop) {
  if (info().state != DeviceState::kArmed) throw DeviceError(kName, "read image", "it is not armed", "Arm it first");
  return NotingFault(info_mutex_, info_, [&] {
    const Clock::time_point deadline = port_->Now() + timeout;
    Exposure exposure;
    exposure.image.columns = options_.columns;
    line_times_.clear();
    const int broken_before = broken_;
    while (exposure.image.rows < options_.lines) {
      const auto telegram = Next(deadline, stop, "read image");
      if (broken_ != broken_before) Fail("read image", "a telegram with a wrong checksum", "Check the cable");
      if (!telegram) {
        throw TimeoutError(kName, "read image",
                           std::to_string(exposure.image.rows) + " of " + std::to_string(options_.lines) +
                               " lines came within " + std::to_string(timeout.count()) + " ms",
                           "Check that its window is clean and its light on");
      }
      std::string error;
      const auto line = cola::DecodeScanLine(*telegram, error);
      if (!line) Fail("read image", error, "Reset the station");
      if (line->status == 1 || line->status == 5) {
        Fail("read image", line->status == 1 ? "the scanner reports an error of its own" : "its window is dirty",
             "Clean the window, or switch the scanner off and on");
      }
      if (line->range.size() < 2 || !(line->step > 0.0))
        Fail("read image", "a line without readings", "Reset the station");
      if (last_counter_ && (line->scan_counter - *last_counter_) % kCounterEnd != 1) {
        Fail("read image",
             "lines were lost between " + std::to_string(*last_counter_) + " and " + std::to_string(line->scan_counter),
             "Check the load of this machine and of its USB bus");
      }
      last_counter_ = line->scan_counter;
      line_times_.emplace_back(line->start_us);
      StoreLine(*line, exposure.image);
    }
    exposure.timestamp = line_times_.front();
    return exposure;
  });
}

void TimRangefinder::Disarm() noexcept {
  if (!port_ || info().state != DeviceState::kArmed) return;
  try {
    NotingFault(info_mutex_, info_, [this] { Ask("sEN LMDscandata 0", kOff, "sEA LMDscandata"); });
    const std::lock_guard lock(info_mutex_);
    info_.state = DeviceState::kIdle;
  } catch (...) {
    // NotingFault has noted it; Reset mends it.
  }
}

void TimRangefinder::Reset() { Open(); }

}  // namespace geond::drivers
