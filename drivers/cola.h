// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// What a SICK TiM scanner and its host say to each other (SOPAS telegrams), as pure functions from bytes to values and
// back: CoLa-A is text between STX and ETX, CoLa-B has a length, big-endian binary and a checksum.
namespace geond::drivers::cola {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

enum class Protocol { kA, kB };

// A telegram without its frame: "sRA LMDscandata ...", from the B protocol with binary numbers after the name.
struct Telegram {
  Protocol protocol = Protocol::kA;
  Bytes content;
  // "sRA", "sSN", "sFA" and so on, and the name that follows ("LMDscandata"); empty where there is none.
  std::string_view kind() const;
  std::string_view name() const;
};

// A command in its frame. `binary` are the numbers after the text in the B protocol; in the A protocol they belong into
// the text. Throws std::invalid_argument if the text has control characters.
Bytes Encode(Protocol protocol, std::string_view text, ByteView binary = {});

// Takes the next whole telegram off the front of a stream of bytes, with what stands before it that is none; none if it
// is not all there yet. A B telegram with a wrong checksum or length is thrown away and counted in `broken`.
std::optional<Telegram> TakeTelegram(Bytes& stream, int& broken);

// The words of an error reply ("sFA 5"); empty if the telegram is none.
std::string ErrorReply(const Telegram& telegram);

// One turn of the scanner's mirror.
struct ScanLine {
  std::uint32_t telegram_counter = 0, scan_counter = 0;
  std::uint32_t start_us = 0;            // since the device was switched on, when the line began
  std::uint16_t status = 0;              // 0: fine; 1: device error; 2: pollution warning; 5: pollution error
  double scan_frequency = 0.0;           // Hz
  double first_angle = 0.0;              // rad, of the first reading, counter-clockwise seen from above
  double step = 0.0;                     // rad from one reading to the next
  std::vector<float> range;              // m, NaN where nothing came back
  std::vector<std::uint16_t> remission;  // 0 to 255; empty, or as many as ranges
};

// The line in an LMDscandata telegram; none, with the broken rule in `error`, if it is not well-formed.
std::optional<ScanLine> DecodeScanLine(const Telegram& telegram, std::string& error);
// The telegram ("sSN") that says a line, ranges to whole millimetres.
Telegram EncodeScanLine(const ScanLine& line, Protocol protocol);

}  // namespace geond::drivers::cola
