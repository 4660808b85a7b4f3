// SPDX-License-Identifier: Apache-2.0
#include "drivers/cola.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include <gtest/gtest.h>

namespace geond::drivers::cola {
namespace {

Bytes Captured(const std::string& name) {
  std::ifstream file(std::string(GEOND_TEST_DATA) + "/tim/" + name, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

Telegram Only(Bytes stream) {
  int broken = 0;
  const auto telegram = TakeTelegram(stream, broken);
  EXPECT_TRUE(telegram && stream.empty() && broken == 0);
  return telegram.value_or(Telegram{});
}

ScanLine SomeLine() {
  ScanLine line;
  line.telegram_counter = 7;
  line.scan_counter = 65535;
  line.start_us = 0xfffffff0;
  line.scan_frequency = 15.0;
  line.first_angle = -45.0 * std::numbers::pi / 180.0;
  line.step = std::numbers::pi / 180.0;
  for (int i = 0; i < 271; ++i) {
    line.range.push_back(i % 9 == 0 ? NAN : 0.001f * static_cast<float>(i * 41 + 1));
    line.remission.push_back(static_cast<std::uint16_t>(i % 256));
  }
  return line;
}

TEST(Cola, CommandsAreTheRecordedOnes) {
  EXPECT_EQ(Encode(Protocol::kA, "sMN SetAccessMode 03 F4724744"), Captured("tim_sMN_SetAccessMode.bin"));
  const Bytes access = {0x03, 0xf4, 0x72, 0x47, 0x44};
  EXPECT_EQ(Encode(Protocol::kB, "sMN SetAccessMode ", access), Captured("colab_SetAccessMode.bin"));
  EXPECT_EQ(Encode(Protocol::kB, "sRN FirmwareVersion"), Captured("colab_FirmwareVersion.bin"));
  EXPECT_EQ(Encode(Protocol::kB, "sRN SCdevicestate"), Captured("colab_SCdevicestate.bin"));
  EXPECT_EQ(Encode(Protocol::kB, "sWN EIHstCola ", Bytes{1}), Captured("colab_EIHstCola1.bin"));
}

TEST(Cola, ARecordedLineHasTheAnglesAndRangesOfItsText) {
  for (const char* name : {"tim55x_sRA_LMDscandata.bin", "tim55x_sSN_LMDscandata.bin"}) {
    std::string error;
    const auto line = DecodeScanLine(Only(Captured(name)), error);
    ASSERT_TRUE(line) << error;
    EXPECT_EQ(line->range.size(), 271u);
    EXPECT_EQ(line->remission.size(), 271u);
    EXPECT_NEAR(line->first_angle, -45.0 * std::numbers::pi / 180.0, 1e-12);
    EXPECT_NEAR(line->step, std::numbers::pi / 180.0, 1e-12);
    EXPECT_DOUBLE_EQ(line->scan_frequency, 15.0);
    EXPECT_EQ(line->status, 0);
  }
  std::string error;
  const auto line = DecodeScanLine(Only(Captured("tim55x_sRA_LMDscandata.bin")), error);
  EXPECT_FLOAT_EQ(line->range[0], 0.278f);  // 116h mm
  EXPECT_FLOAT_EQ(line->range[1], 0.288f);  // 120h
  EXPECT_EQ(line->start_us, 0x7907F6FDu);
  EXPECT_EQ(line->telegram_counter, 0x2AD8u);
}

TEST(Cola, LinesRoundTripInBothProtocols) {
  const ScanLine line = SomeLine();
  for (const Protocol protocol : {Protocol::kA, Protocol::kB}) {
    const Telegram telegram = EncodeScanLine(line, protocol);
    const Bytes framed = protocol == Protocol::kA
                             ? Encode(protocol, std::string(telegram.content.begin(), telegram.content.end()))
                             : Encode(protocol, "", telegram.content);
    std::string error;
    const auto again = DecodeScanLine(Only(framed), error);
    ASSERT_TRUE(again) << error;
    EXPECT_EQ(again->start_us, line.start_us);
    EXPECT_EQ(again->scan_counter, line.scan_counter);
    EXPECT_EQ(again->remission, line.remission);
    EXPECT_NEAR(again->first_angle, line.first_angle, 1e-9);
    ASSERT_EQ(again->range.size(), line.range.size());
    for (std::size_t i = 0; i < line.range.size(); ++i) {
      EXPECT_EQ(std::isnan(again->range[i]), std::isnan(line.range[i]));
      if (!std::isnan(line.range[i])) {
        EXPECT_NEAR(again->range[i], line.range[i], 1e-6);
      }
    }
  }
}

TEST(Cola, TelegramsAreFoundInAStreamHoweverItIsCut) {
  const ScanLine line = SomeLine();
  Bytes whole = {0x55, 0x03, 0x41};  // the end of something before
  for (const Protocol protocol : {Protocol::kA, Protocol::kB}) {
    const Telegram telegram = EncodeScanLine(line, protocol);
    const Bytes framed = protocol == Protocol::kA
                             ? Encode(protocol, std::string(telegram.content.begin(), telegram.content.end()))
                             : Encode(protocol, "", telegram.content);
    whole.insert(whole.end(), framed.begin(), framed.end());
  }
  for (const std::size_t cut : {1u, 7u, 64u, 1024u}) {
    Bytes stream;
    int found = 0, broken = 0;
    for (std::size_t at = 0; at < whole.size(); at += cut) {
      stream.insert(stream.end(), whole.begin() + static_cast<std::ptrdiff_t>(at),
                    whole.begin() + static_cast<std::ptrdiff_t>(std::min(at + cut, whole.size())));
      std::string error;
      while (const auto telegram = TakeTelegram(stream, broken)) found += DecodeScanLine(*telegram, error).has_value();
    }
    EXPECT_EQ(found, 2) << cut;
    EXPECT_EQ(broken, 0) << cut;
  }
}

TEST(Cola, WhatIsBrokenIsNamed) {
  Bytes damaged = Captured("colab_FirmwareVersion.bin");
  damaged.back() ^= 1;
  int broken = 0;
  EXPECT_FALSE(TakeTelegram(damaged, broken));
  EXPECT_GT(broken, 0);
  const std::string text = "sRA LMDscandata 1 1 107375C 0 0 2AD8";
  std::string error;
  EXPECT_FALSE(DecodeScanLine({Protocol::kA, Bytes(text.begin(), text.end())}, error));
  EXPECT_EQ(error, "scan data that ends too soon");
  const std::string refusal = "sFA 5";
  EXPECT_EQ(ErrorReply({Protocol::kA, Bytes(refusal.begin(), refusal.end())}), "the scanner refuses, error 5");
  EXPECT_FALSE(DecodeScanLine({Protocol::kA, Bytes(refusal.begin(), refusal.end())}, error));
  // Every beginning of a line is refused, none crashes.
  for (const Protocol protocol : {Protocol::kA, Protocol::kB}) {
    const Telegram whole = EncodeScanLine(SomeLine(), protocol);
    for (std::size_t size = 0; size + 20 < whole.content.size(); size += 3) {
      Telegram part{protocol, Bytes(whole.content.begin(), whole.content.begin() + static_cast<std::ptrdiff_t>(size))};
      EXPECT_FALSE(DecodeScanLine(part, error)) << size;
    }
  }
}

}  // namespace
}  // namespace geond::drivers::cola
