// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

typedef struct _modbus modbus_t;

namespace geond::drivers {

// Where a Modbus device is reached: a serial line (RTU) if `serial_device` is set, else TCP.
struct ModbusAddress {
  std::string serial_device;
  int baud = 115200;
  char parity = 'E';
  int stop_bits = 1;
  std::string host;
  int port = 502;
  int unit = 1;
  std::chrono::milliseconds response_timeout{100};
  // After so much silence no late reply is to be expected any more; absent: the response timeout.
  std::optional<std::chrono::milliseconds> quiet_time = {};
  std::chrono::milliseconds probe_timeout{30};  // for an answer at settings that are only tried
};

// One Modbus connection with no recovery of libmodbus' own. After any failure the next request first makes sure that no
// late reply is under way, so that a stale reply is never taken for a fresh one. Blocking; one thread at a time.
// Every request throws TimeoutError (no reply in time) or DeviceError (refused, broken, line lost).
class ModbusLink {
 public:
  // `name` is the device, for messages. `probe` is a register that can be read at any time.
  ModbusLink(std::string name, ModbusAddress address, std::uint16_t probe);
  ~ModbusLink();
  ModbusLink(ModbusLink&&) noexcept = default;
  ModbusLink& operator=(ModbusLink&&) noexcept = default;

  struct Free { void operator()(modbus_t* context) const; };
  // A connection of its own, or none and errno.
  static std::unique_ptr<modbus_t, Free> Open(const ModbusAddress& address);

  bool connected() const { return context_ != nullptr; }
  void Connect();
  void Close() noexcept { context_.reset(); }
  std::vector<std::uint16_t> Read(std::uint16_t address, int count);
  void Write(std::uint16_t address, std::span<const std::uint16_t> values);
  // Writes at once, whatever is still under way, and says whether it was acknowledged; no longer than one reply takes.
  bool WriteOnce(std::uint16_t address, std::span<const std::uint16_t> values) noexcept;

 private:
  void Ready();
  void Resynchronise();
  // Throws away what comes in until nothing has for the quiet time; false if it never ends.
  bool DrainUntilQuiet();
  int quiet_ms() const { return static_cast<int>(address_.quiet_time.value_or(address_.response_timeout).count()); }
  [[noreturn]] void Fail(const std::string& call, int error);

  std::string name_;
  ModbusAddress address_;
  std::uint16_t probe_;
  std::unique_ptr<modbus_t, Free> context_;
  bool suspect_ = false;  // a reply may still be under way
};

// What is wrong with the settings of a serial line on which nothing answers: tries other speeds and parities, the probe's
// time each, and says with which the device answers; empty if with none, or if it is no serial line.
std::string FindLineSettings(const ModbusAddress& address, std::uint16_t probe);

}  // namespace geond::drivers
