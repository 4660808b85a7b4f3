// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <numbers>
#include <string>
#include <vector>

#include "drivers/cola.h"
#include "drivers/rangefinder.h"
#include "drivers/usb_port.h"

namespace geond::drivers {

struct TimRangefinderOptions {
  int columns = 271;                      // of the image: readings across the field
  int lines = 60;                         // rows of the image: lines stacked while the table turns
  double field = 0.5 * std::numbers::pi;  // rad, across: the middle of what the scanner sees, below pi
  double depth_noise = 0.01;              // m
  std::chrono::milliseconds response_time{1000};
};

// A SICK TiM 3xx or 5xx line scanner. Its image is a stack of lines, taken while the table turns: the columns go across
// the scanner's plane as those of a perspective camera do, the rows are one line each, line_times() says when each was
// taken by the device's clock. Its laser (class 1) is always on; there is no trigger wire: Trigger begins a new stack.
// After CoLa-A is not understood it speaks CoLa-B.
class TimRangefinder final : public Rangefinder {
 public:
  // Opens the scanner and reads what it is. Throws DeviceError, TimeoutError, std::invalid_argument.
  TimRangefinder(UsbOpener open, TimRangefinderOptions options);
  ~TimRangefinder() override;

  DeviceInfo info() const override;
  // Of a line: perspective across, one row.
  SensorModel sensor_model() const override { return sensor_; }
  void Arm() override;
  void Trigger() override;
  Exposure Read(std::chrono::milliseconds timeout, std::stop_token stop) override;
  void Disarm() noexcept override;
  void Reset() override;

  // Of the rows of the image read last, by the device's clock.
  const std::vector<std::chrono::microseconds>& line_times() const { return line_times_; }

 private:
  void Open();
  cola::Telegram Ask(const std::string& text, cola::ByteView binary, const std::string& reply);
  std::optional<cola::Telegram> Next(std::chrono::steady_clock::time_point deadline, std::stop_token stop,
                                     const char* call);
  void StoreLine(const cola::ScanLine& line, RangeImage& image) const;
  [[noreturn]] void Fail(const char* call, const std::string& cause, const std::string& remedy) const;

  const UsbOpener open_;
  const TimRangefinderOptions options_;
  SensorModel sensor_;
  mutable std::mutex info_mutex_;
  DeviceInfo info_;
  std::unique_ptr<UsbPort> port_;
  cola::Protocol protocol_ = cola::Protocol::kA;
  cola::Bytes received_;
  int broken_ = 0;
  std::optional<std::uint32_t> last_counter_;
  std::vector<std::chrono::microseconds> line_times_;
};

}  // namespace geond::drivers
