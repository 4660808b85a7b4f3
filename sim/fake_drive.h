// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>

namespace geond::sim {

// How a fake drive misbehaves on the wire.
enum class WireFault {
  kNone,
  kOff,           // no reply
  kStuck,         // replies, but the motor does not turn
  kGarbage,       // replies with rubbish
  kWrong,         // refuses every request (exception 04, or that of SetException)
  kSlow,          // replies late, but in time (FakeDriveOptions::slow)
  kDelayed,       // replies after the master gave up (FakeDriveOptions::late)
  kIntermittent,  // every third reply is lost
  kBadChecksum,   // a well-formed reply but for its checksum
  kHalfFrame,     // stops in the middle of a reply
  kWrongUnit,     // replies as another unit
  kCrawling,      // turns at a twentieth of the speed it was told
};

struct FakeDriveOptions {
  int unit = 1;
  double position = 1234.0;  // steps, where the motor stands at first
  // Settings of the serial line that it understands; on others it hears nothing. 0: on any.
  int baud = 0;
  char parity = 'E';
  std::chrono::milliseconds slow{30}, late{150};  // how long replies take by these faults
};

// A drive of Oriental Motor's BLV-R kind at the wire: a Modbus server of its own on a pseudo-terminal (RTU) or on loopback
// TCP, with the registers of config/drives/oriental_blv_r.toml. It turns in real time at the speed asked for, without
// ramps; it stops with alarm 85h when its communication timeout or a motion's lifetime runs out. Serves on a thread of its
// own until destroyed.
class FakeDrive {
 public:
  enum class Transport { kPseudoTerminal, kTcp };
  explicit FakeDrive(Transport transport, const FakeDriveOptions& options = {});
  ~FakeDrive();

  std::string serial_device() const;  // the terminal to open, kPseudoTerminal
  int port() const;                   // on 127.0.0.1, kTcp
  void SetFault(WireFault fault);
  void SetException(int code);  // of kWrong
  // Raises an alarm, as if its cause had come up.
  void RaiseAlarm(int code);
  // As the motor really is, whatever the wire says.
  double position() const;  // steps
  bool moving() const;
  bool enabled() const;
  // Power of the motor, as a contactor switches it; without it the motor stands and lets go.
  void SetPower(bool on);
  // Cuts the connection (TCP) or hangs up the terminal.
  void Unplug();

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace geond::sim
