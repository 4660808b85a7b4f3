// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace geond::drivers {

// What the camera driver needs of USB: one device, opened, its control and stream endpoints. One thread.
class UsbPort {
 public:
  enum class Status { kOk, kTimeout, kStall, kOverflow, kGone, kCancelled, kFailed };
  struct Result {
    Status status = Status::kFailed;
    std::size_t size = 0;  // bytes that went over
  };
  virtual ~UsbPort() = default;
  // The clock by which waits on this port are counted; another than the real one if the device is simulated within this
  // process.
  virtual std::chrono::steady_clock::time_point Now() const { return std::chrono::steady_clock::now(); }
  virtual std::string model() const = 0;
  virtual std::string identity() const = 0;  // GUID or serial number
  virtual Result ControlOut(std::span<const std::uint8_t> data, std::chrono::milliseconds timeout) = 0;
  virtual Result ControlIn(std::span<std::uint8_t> buffer, std::chrono::milliseconds timeout) = 0;
  virtual Status ClearControlHalt() = 0;
  // Whether the device is still plugged in; does not wait.
  virtual bool Present() = 0;
  // Posts a read of the stream; `buffer` must live until the read is reaped or cancelled.
  virtual Status PostRead(std::span<std::uint8_t> buffer) = 0;
  // The oldest read posted, once it is over; nothing if that takes longer than `timeout`.
  virtual std::optional<Result> Reap(std::chrono::milliseconds timeout) = 0;
  // Ends all posted reads; on return none is under way. Never throws.
  virtual void CancelReads() noexcept = 0;
  // Halts the stream endpoint and clears the halt, which resets the device's stream. With no read posted.
  virtual Status ResetStream() = 0;
  // Resets the whole device, which may need to be opened again then.
  virtual Status ResetDevice() = 0;
};

std::string_view UsbStatusWords(UsbPort::Status status);

// Opens the one device there is, or that with this GUID or serial number. Throws DeviceError.
using UsbOpener = std::function<std::unique_ptr<UsbPort>()>;

}  // namespace geond::drivers
