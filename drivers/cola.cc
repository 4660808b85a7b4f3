// SPDX-License-Identifier: Apache-2.0
#include "drivers/cola.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace geond::drivers::cola {
namespace {

constexpr std::uint8_t kStx = 0x02, kEtx = 0x03;
constexpr std::size_t kBinaryHeader = 8;                       // four STX and the length
constexpr std::size_t kLongest = 64 << 10;                     // of a telegram
constexpr std::size_t kMostReadings = 4096;                    // of a line; a TiM has 811
constexpr double kAngleUnit = std::numbers::pi / 180.0 / 1e4;  // rad

std::string_view Text(ByteView bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// The word number `index` of a telegram, words being divided by one space.
std::string_view Word(std::string_view text, std::size_t index) {
  for (; index > 0; --index) {
    const std::size_t space = text.find(' ');
    if (space == std::string_view::npos) return {};
    text.remove_prefix(space + 1);
  }
  return text.substr(0, text.find(' '));
}

// The numbers of a line in their order, whichever way they are written. After a failure all that comes is 0.
class Reader {
 public:
  virtual ~Reader() = default;
  virtual std::uint32_t Number(int bytes) = 0;
  virtual std::string Name() = 0;  // of a channel, five letters
  double Float() { return std::bit_cast<float>(Number(4)); }
  bool good() const { return good_; }

 protected:
  bool good_ = true;
};

class TextReader final : public Reader {
 public:
  explicit TextReader(std::string_view text) : text_(text) {}
  std::uint32_t Number(int) override {
    const std::string_view word = Next();
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, 16);
    good_ = good_ && !word.empty() && error == std::errc() && end == word.data() + word.size();
    return good_ ? value : 0;
  }
  std::string Name() override { return std::string(Next()); }

 private:
  std::string_view Next() {
    const std::size_t end = std::min(text_.find(' '), text_.size());
    const std::string_view word = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    return word;
  }
  std::string_view text_;
};

class BinaryReader final : public Reader {
 public:
  explicit BinaryReader(ByteView bytes) : bytes_(bytes) {}
  std::uint32_t Number(int bytes) override {
    std::uint32_t value = 0;
    for (const std::uint8_t byte : Next(static_cast<std::size_t>(bytes))) value = value << 8 | byte;
    return value;
  }
  std::string Name() override { return std::string(Text(Next(5))); }

 private:
  ByteView Next(std::size_t count) {
    good_ = good_ && count <= bytes_.size();
    if (!good_) return {};
    const ByteView next = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return next;
  }
  ByteView bytes_;
};

// The same the other way.
class Writer {
 public:
  Writer(Protocol protocol, std::string_view name) : protocol_(protocol), bytes_(name.begin(), name.end()) {}
  void Number(std::uint32_t value, int bytes) {
    if (protocol_ == Protocol::kB) {
      for (int i = bytes - 1; i >= 0; --i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
      return;
    }
    char digits[16];
    const int count = std::snprintf(digits, sizeof digits, " %X", value);
    bytes_.insert(bytes_.end(), digits, digits + count);
  }
  void Float(double value) { Number(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4); }
  void Name(std::string_view name) {
    if (protocol_ == Protocol::kA) bytes_.push_back(' ');
    bytes_.insert(bytes_.end(), name.begin(), name.end());
  }
  Bytes Take() { return std::move(bytes_); }

 private:
  const Protocol protocol_;
  Bytes bytes_;
};

struct Channel {
  std::string name;
  double scale = 1.0, offset = 0.0;
  double first_angle = 0.0, step = 0.0;
  std::vector<std::uint32_t> values;
};

Channel ReadChannel(Reader& reader, int bytes) {
  Channel channel;
  channel.name = reader.Name();
  channel.scale = reader.Float();
  channel.offset = reader.Float();
  channel.first_angle = static_cast<std::int32_t>(reader.Number(4)) * kAngleUnit;
  channel.step = static_cast<double>(reader.Number(2)) * kAngleUnit;
  const std::uint32_t count = reader.Number(2);
  if (count > kMostReadings) return channel;
  for (std::uint32_t i = 0; i < count && reader.good(); ++i) channel.values.push_back(reader.Number(bytes));
  return channel;
}

void WriteChannel(Writer& writer, const char* name, const ScanLine& line, std::size_t count) {
  writer.Name(name);
  writer.Float(1.0);
  writer.Float(0.0);
  writer.Number(static_cast<std::uint32_t>(static_cast<std::int32_t>(std::llround(line.first_angle / kAngleUnit))), 4);
  writer.Number(static_cast<std::uint32_t>(std::llround(line.step / kAngleUnit)), 2);
  writer.Number(static_cast<std::uint32_t>(count), 2);
}

}  // namespace

std::string_view Telegram::kind() const { return Word(Text(content), 0); }

std::string_view Telegram::name() const { return Word(Text(content), 1); }

Bytes Encode(Protocol protocol, std::string_view text, ByteView binary) {
  for (const char c : text) {
    if (c < ' ') throw std::invalid_argument("cola::Encode: a command has no control characters");
  }
  Bytes bytes;
  if (protocol == Protocol::kA) {
    bytes.push_back(kStx);
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.push_back(kEtx);
    return bytes;
  }
  const auto size = static_cast<std::uint32_t>(text.size() + binary.size());
  bytes.assign(4, kStx);
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(size >> shift));
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.insert(bytes.end(), binary.begin(), binary.end());
  std::uint8_t sum = 0;
  for (std::size_t i = kBinaryHeader; i < bytes.size(); ++i) sum ^= bytes[i];
  bytes.push_back(sum);
  return bytes;
}

std::optional<Telegram> TakeTelegram(Bytes& stream, int& broken) {
  while (true) {
    const auto start = std::find(stream.begin(), stream.end(), kStx);
    stream.erase(stream.begin(), start);
    if (stream.size() < 2) return std::nullopt;
    if (stream[1] != kStx) {
      const auto end = std::find(stream.begin(), stream.end(), kEtx);
      if (end == stream.end()) {
        if (stream.size() <= kLongest) return std::nullopt;
        ++broken;
        stream.clear();
        return std::nullopt;
      }
      Telegram telegram{Protocol::kA, Bytes(stream.begin() + 1, end)};
      stream.erase(stream.begin(), end + 1);
      return telegram;
    }
    if (stream.size() < kBinaryHeader) return std::nullopt;
    const std::size_t size = std::size_t{stream[4]} << 24 | stream[5] << 16 | stream[6] << 8 | stream[7];
    if (stream[2] == kStx && stream[3] == kStx && size <= kLongest) {
      if (stream.size() < kBinaryHeader + size + 1) return std::nullopt;
      Bytes content(stream.begin() + kBinaryHeader, stream.begin() + static_cast<std::ptrdiff_t>(kBinaryHeader + size));
      std::uint8_t sum = 0;
      for (const std::uint8_t byte : content) sum ^= byte;
      if (sum == stream[kBinaryHeader + size]) {
        stream.erase(stream.begin(), stream.begin() + static_cast<std::ptrdiff_t>(kBinaryHeader + size + 1));
        return Telegram{Protocol::kB, std::move(content)};
      }
    }
    ++broken;
    stream.erase(stream.begin());  // it may begin one byte later
  }
}

std::string ErrorReply(const Telegram& telegram) {
  if (telegram.kind() != "sFA") return {};
  const std::string_view code = telegram.name();
  return "the scanner refuses, error " + (telegram.protocol == Protocol::kA || code.empty()
                                              ? std::string(code)
                                              : std::to_string(static_cast<unsigned char>(code.back())));
}

std::optional<ScanLine> DecodeScanLine(const Telegram& telegram, std::string& error) {
  const auto fail = [&error](const char* rule) {
    error = rule;
    return std::nullopt;
  };
  if (const std::string refusal = ErrorReply(telegram); !refusal.empty()) return fail("the scanner refuses");
  if ((telegram.kind() != "sSN" && telegram.kind() != "sRA") || telegram.name() != "LMDscandata")
    return fail("no scan data");
  const std::size_t head = std::string_view("sSN LMDscandata ").size();
  if (telegram.content.size() <= head) return fail("scan data that ends too soon");
  const ByteView rest = ByteView(telegram.content).subspan(head);
  TextReader text(Text(rest));
  BinaryReader binary(rest);
  Reader& reader = telegram.protocol == Protocol::kA ? static_cast<Reader&>(text) : binary;
  ScanLine line;
  reader.Number(2);  // version
  reader.Number(2);  // device number
  reader.Number(4);  // serial number
  const std::uint32_t high = reader.Number(1), low = reader.Number(1);
  line.status = static_cast<std::uint16_t>(high << 8 | low);
  line.telegram_counter = reader.Number(2);
  line.scan_counter = reader.Number(2);
  line.start_us = reader.Number(4);
  reader.Number(4);                              // when it was sent
  for (int i = 0; i < 4; ++i) reader.Number(1);  // inputs, outputs
  if (reader.Number(2) != 0) return fail("scan data of another layout");
  line.scan_frequency = 0.01 * reader.Number(4);
  reader.Number(4);  // measurements a second
  for (std::uint32_t encoders = reader.Number(2); encoders > 0 && reader.good(); --encoders) {
    reader.Number(4);
    reader.Number(2);
  }
  const std::uint32_t channels = reader.Number(2);
  if (!reader.good()) return fail("scan data that ends too soon");
  if (channels < 1) return fail("scan data without ranges");
  const Channel ranges = ReadChannel(reader, 2);
  if (ranges.name != "DIST1") return fail("a first channel that is not DIST1");
  for (std::uint32_t i = 1; i < channels && reader.good(); ++i) ReadChannel(reader, 2);
  const std::uint32_t small_channels = reader.Number(2);
  if (!reader.good() || ranges.values.empty()) return fail("scan data that ends too soon");
  line.first_angle = ranges.first_angle;
  line.step = ranges.step;
  if (!std::isfinite(ranges.scale) || !std::isfinite(ranges.offset)) return fail("a scale that is no number");
  for (const std::uint32_t value : ranges.values) {
    line.range.push_back(value == 0 ? std::numeric_limits<float>::quiet_NaN()
                                    : static_cast<float>(1e-3 * (value * ranges.scale + ranges.offset)));
  }
  if (small_channels == 0) return line;
  const Channel remission = ReadChannel(reader, 1);
  if (!reader.good()) return fail("scan data that ends too soon");
  if (remission.values.size() != ranges.values.size()) return fail("another number of remissions than of ranges");
  for (const std::uint32_t value : remission.values) line.remission.push_back(static_cast<std::uint16_t>(value));
  return line;
}

Telegram EncodeScanLine(const ScanLine& line, Protocol protocol) {
  Writer writer(protocol, protocol == Protocol::kA ? "sSN LMDscandata" : "sSN LMDscandata ");
  writer.Number(1, 2);
  writer.Number(1, 2);
  writer.Number(0x0107375C, 4);
  writer.Number(line.status >> 8, 1);
  writer.Number(line.status & 0xff, 1);
  writer.Number(line.telegram_counter & 0xffff, 2);
  writer.Number(line.scan_counter & 0xffff, 2);
  writer.Number(line.start_us, 4);
  writer.Number(line.start_us + 66'000, 4);
  for (int i = 0; i < 4; ++i) writer.Number(0, 1);
  writer.Number(0, 2);
  writer.Number(static_cast<std::uint32_t>(std::llround(100.0 * line.scan_frequency)), 4);
  writer.Number(54, 4);
  writer.Number(0, 2);
  writer.Number(1, 2);
  WriteChannel(writer, "DIST1", line, line.range.size());
  for (const float range : line.range) {
    writer.Number(std::isnan(range) ? 0u : static_cast<std::uint32_t>(std::clamp(std::lround(range * 1e3), 0L, 65535L)),
                  2);
  }
  writer.Number(line.remission.empty() ? 0 : 1, 2);
  if (!line.remission.empty()) {
    WriteChannel(writer, "RSSI1", line, line.remission.size());
    for (const std::uint16_t value : line.remission) writer.Number(value, 1);
  }
  for (int i = 0; i < 5; ++i) writer.Number(0, 2);  // position, name, comment, time, event: none
  return {protocol, writer.Take()};
}

}  // namespace geond::drivers::cola
