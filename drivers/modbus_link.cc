// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus_link.h"

#include <cerrno>
#include <poll.h>
#include <unistd.h>

#include <modbus/modbus.h>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

constexpr int kResyncRounds = 5;
constexpr int kMostStrayBytes = 4096;

// The registers cannot be asked for, as against a reply that is lost or broken: the line is in order.
bool IsModbusException(int error) { return error > MODBUS_ENOBASE && error < EMBBADCRC; }

bool IsLineLost(int error) {
  return error == EIO || error == EPIPE || error == ECONNRESET || error == EBADF || error == ENXIO || error == ENODEV ||
         error == ECONNREFUSED || error == ENOTCONN;
}

}  // namespace

void ModbusLink::Free::operator()(modbus_t* context) const {
  modbus_close(context);
  modbus_free(context);
}

std::unique_ptr<modbus_t, ModbusLink::Free> ModbusLink::Open(const ModbusAddress& address) {
  const bool serial = !address.serial_device.empty();
  std::unique_ptr<modbus_t, Free> context(
      serial ? modbus_new_rtu(address.serial_device.c_str(), address.baud, address.parity, 8, address.stop_bits)
             : modbus_new_tcp(address.host.c_str(), address.port));
  if (!context) return nullptr;
  const auto timeout = std::chrono::duration_cast<std::chrono::microseconds>(address.response_timeout).count();
  modbus_set_error_recovery(context.get(), MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_response_timeout(context.get(), static_cast<std::uint32_t>(timeout / 1'000'000),
                              static_cast<std::uint32_t>(timeout % 1'000'000));
  // And half a reply is no more worth waiting for.
  modbus_set_byte_timeout(context.get(), static_cast<std::uint32_t>(timeout / 1'000'000),
                          static_cast<std::uint32_t>(timeout % 1'000'000));
  modbus_set_slave(context.get(), address.unit);
  if (modbus_connect(context.get()) != 0) {
    const int error = errno;
    context.reset();
    errno = error;
  }
  return context;
}

ModbusLink::ModbusLink(std::string name, ModbusAddress address, std::uint16_t probe)
    : name_(std::move(name)), address_(std::move(address)), probe_(probe) {}

ModbusLink::~ModbusLink() = default;

void ModbusLink::Connect() {
  const bool serial = !address_.serial_device.empty();
  const std::string where = serial ? address_.serial_device : address_.host + ":" + std::to_string(address_.port);
  context_ = Open(address_);
  if (!context_) {
    const int error = errno;
    const std::string remedy =
        !serial                                     ? "Is the drive on, and is the address right?"
        : error == EACCES || error == EPERM         ? "Add this user to the group dialout"
        : error == ENOENT || error == ENXIO         ? "Plug the adapter in, or correct turntable.serial"
        : error == EBUSY                            ? "Another program uses the port: end it"
                                                    : "Check turntable.serial and the adapter";
    throw DeviceError(name_, "connect to " + where, modbus_strerror(error), remedy);
  }
  suspect_ = serial;  // whoever spoke on this line before may still be waited for
}

std::vector<std::uint16_t> ModbusLink::Read(std::uint16_t address, int count) {
  Ready();
  std::vector<std::uint16_t> words(count);
  if (modbus_read_registers(context_.get(), address, count, words.data()) != count) {
    Fail("read " + std::to_string(count) + " registers at " + std::to_string(address), errno);
  }
  return words;
}

void ModbusLink::Write(std::uint16_t address, std::span<const std::uint16_t> values) {
  Ready();
  const int count = static_cast<int>(values.size());
  if (modbus_write_registers(context_.get(), address, count, values.data()) != count) {
    Fail("write " + std::to_string(count) + " registers at " + std::to_string(address), errno);
  }
}

bool ModbusLink::WriteOnce(std::uint16_t address, std::span<const std::uint16_t> values) noexcept {
  if (!context_) return false;
  modbus_flush(context_.get());
  const int count = static_cast<int>(values.size());
  const bool done = modbus_write_registers(context_.get(), address, count, values.data()) == count;
  suspect_ = suspect_ || !done;
  return done;
}

void ModbusLink::Ready() {
  if (!context_) Connect();
  if (suspect_) Resynchronise();
}

// A serial reply has no number: if one comes too late, the next request gets it, and so on for ever. So: wait for silence,
// ask one question, and believe the line only if silence follows its answer. On TCP a new connection does the same.
void ModbusLink::Resynchronise() {
  if (address_.serial_device.empty()) {
    Connect();
    return;
  }
  for (int round = 0; round < kResyncRounds; ++round) {
    std::uint16_t word = 0;
    if (!DrainUntilQuiet()) break;
    if (modbus_read_registers(context_.get(), probe_, 1, &word) != 1) {
      const int error = errno;
      if (IsLineLost(error)) Fail("find out whether the line is in order", error);
      if (!IsModbusException(error)) continue;
    }
    pollfd line{modbus_get_socket(context_.get()), POLLIN, 0};
    if (poll(&line, 1, quiet_ms()) == 0) {
      suspect_ = false;
      return;
    }
  }
  throw TimeoutError(name_, "find out whether the line is in order", "no clean answer in " + std::to_string(kResyncRounds) + " tries",
                     "Check power, wiring, baud rate, parity and unit number");
}

bool ModbusLink::DrainUntilQuiet() {
  int stray = 0;
  for (;;) {
    pollfd line{modbus_get_socket(context_.get()), POLLIN, 0};
    if (poll(&line, 1, quiet_ms()) <= 0) return true;
    std::uint8_t bytes[256];
    const ssize_t n = read(line.fd, bytes, sizeof bytes);
    if (n <= 0) Fail("read from the line", n == 0 ? EIO : errno);
    stray += static_cast<int>(n);
    if (stray > kMostStrayBytes) return false;
  }
}

void ModbusLink::Fail(const std::string& call, int error) {
  if (IsModbusException(error)) throw DeviceError(name_, call, modbus_strerror(error), "Does the profile fit this drive?");
  suspect_ = true;
  if (IsLineLost(error)) {
    Close();
    throw DeviceError(name_, call, std::string("the line is lost (") + modbus_strerror(error) + ")",
                      "Check cable and adapter, then reset");
  }
  if (error == ETIMEDOUT || error == EAGAIN) {
    throw TimeoutError(name_, call, "no reply within " + std::to_string(address_.response_timeout.count()) + " ms",
                       "Check power, wiring, baud rate, parity and unit number");
  }
  throw DeviceError(name_, call, modbus_strerror(error), "Check wiring and termination for noise");
}

std::string FindLineSettings(const ModbusAddress& address, std::uint16_t probe) {
  if (address.serial_device.empty()) return {};
  for (const int baud : {address.baud, 9600, 19200, 38400, 57600, 115200, 230400}) {
    for (const char parity : {'E', 'N', 'O'}) {
      if (baud == address.baud ? parity == address.parity : false) continue;
      ModbusAddress other = address;
      other.baud = baud;
      other.parity = parity;
      other.response_timeout = address.probe_timeout;
      const auto context = ModbusLink::Open(other);
      std::uint16_t word = 0;
      if (!context) return {};
      modbus_flush(context.get());
      if (modbus_read_registers(context.get(), probe, 1, &word) != 1 && !IsModbusException(errno)) continue;
      const std::string name = parity == 'E' ? "even" : parity == 'O' ? "odd" : "no";
      return "it answers at " + std::to_string(baud) + " baud with " + name + " parity";
    }
  }
  return {};
}

}  // namespace geond::drivers
