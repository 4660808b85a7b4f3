// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "drivers/u3v_protocol.h"
#include "drivers/usb_port.h"

namespace geond::drivers::u3v {

struct ControlOptions {
  std::chrono::milliseconds response_time{200};  // how long an answer may take, at least
  std::chrono::milliseconds longest_response_time{2000};  // whatever the device says of itself
  int tries = 5;
};

// Reads and writes the camera's registers: one command under way, repeated with a new number when its answer is lost or
// broken, late answers to earlier ones thrown away. Throws TimeoutError, DeviceError (refused, unplugged).
class ControlChannel {
 public:
  explicit ControlChannel(UsbPort& port, ControlOptions options = {}) : port_(port), options_(options) {}

  // Reads from the camera how long it takes and how much goes into one command. Call it once.
  void Negotiate();
  Bytes Read(std::uint64_t address, std::size_t count);
  void Write(std::uint64_t address, ByteView data);
  std::uint32_t Read32(std::uint64_t address);
  std::uint64_t Read64(std::uint64_t address);
  std::string ReadText(std::uint64_t address, std::size_t count);
  void Write32(std::uint64_t address, std::uint32_t value);
  std::uint64_t stream_registers() const { return stream_registers_; }
  int repeats() const { return repeats_; }  // commands sent again, so far

 private:
  Ack Transact(Command command, std::uint64_t address, ByteView data, std::size_t count);

  UsbPort& port_;
  const ControlOptions options_;
  std::chrono::milliseconds response_time_ = options_.response_time;
  std::size_t max_command_ = 64, max_acknowledge_ = 64 + kControlHeaderSize;
  std::uint64_t stream_registers_ = 0;
  std::uint16_t request_id_ = 0;
  int repeats_ = 0;
};

}  // namespace geond::drivers::u3v
