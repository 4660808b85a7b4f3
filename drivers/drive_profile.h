// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace geond::drivers {

// A quantity in a drive's registers.
struct DriveRegister {
  enum class Type { kU16, kI16, kU32, kI32 };
  std::uint16_t address = 0;
  Type type = Type::kU16;
  int words() const { return type == Type::kU32 || type == Type::kI32 ? 2 : 1; }
};

// What a sequence writes: a number, or one the driver knows by name: "target" (steps), "speed" (the drive's unit), "accel",
// "decel" (the drive's unit), "lifetime_ms".
using DriveValue = std::variant<std::int64_t, std::string>;

// One step of a sequence.
struct DriveStep {
  enum class Kind { kWrite, kWait };
  Kind kind = Kind::kWrite;
  std::string name;                           // the register, for messages
  std::uint16_t address = 0;                  // kWrite: first register of the block
  std::vector<std::pair<DriveRegister::Type, DriveValue>> values;  // kWrite: written in one request
  std::uint32_t mask = 0, equals = 0;         // kWait: until (status & mask) == equals, ...
  std::chrono::milliseconds timeout{2000};    // ... or this long
};

// How a Modbus drive is spoken to: registers, bits and sequences, so that a new drive needs no code. Read from
// config/drives/*.toml, which says what each key means.
struct DriveProfile {
  std::string name;
  bool high_word_first = true;    // of 32-bit quantities
  int baud = 115200;              // serial line, as delivered
  char parity = 'E';              // 'N', 'E', 'O'
  int stop_bits = 1;
  double steps_per_turn = 36000;  // of the motor's shaft
  double speed_factor = 1.0;      // drive's unit of speed for one step a second
  // How acceleration is given: in the drive's unit, accel_factor of it being one step a second squared; or as time,
  // accel_factor times the milliseconds from rest to full speed or to 1000 turns a minute.
  enum class Accel { kRate, kTime, kTimePerThousandRpm };
  Accel accel = Accel::kRate;
  double accel_factor = 1.0;
  DriveRegister status, position, alarm;
  std::uint32_t moving = 0, in_position = 0, alarmed = 0, homed = 0, enabled = 0;  // masks of `status`; 0: the drive does not say
  std::uint32_t alarm_mask = 0xffff;                                  // of `alarm`
  std::chrono::milliseconds lifetime{0};                              // of a motion without new commands; 0: none
  // Read back after it is written, so that a dead service stops the motor; address 0: the drive has none.
  DriveRegister communication_timeout;
  std::chrono::milliseconds communication_timeout_value{0};
  std::map<std::string, std::vector<DriveStep>> sequences;  // enable, home, move, stop, quick_stop, disable, reset
  std::map<std::uint32_t, std::string> alarm_words;         // the drive's own words for its alarms
};

// Throws ConfigError naming file, line and key.
DriveProfile ReadDriveProfile(const std::filesystem::path& path);

}  // namespace geond::drivers
