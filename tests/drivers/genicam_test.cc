// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam.h"

#include <cmath>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/genicam_formula.h"

namespace geond::drivers::genicam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string CameraXml() {
  std::ifstream file(std::string(GEOND_TEST_DATA) + "/u3v/camera.xml");
  return {std::istreambuf_iterator<char>(file), {}};
}

class GenicamTest : public testing::Test {
 protected:
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(0x400);
  Memory memory_{[this](std::uint64_t address, std::size_t count) {
                   return std::vector<std::uint8_t>(bytes_.begin() + static_cast<std::ptrdiff_t>(address),
                                                    bytes_.begin() + static_cast<std::ptrdiff_t>(address + count));
                 },
                 [this](std::uint64_t address, std::span<const std::uint8_t> data) {
                   std::copy(data.begin(), data.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(address));
                 }};
  Description camera_{CameraXml()};

  std::vector<int> At(std::size_t address, std::size_t count) const {
    return {bytes_.begin() + static_cast<std::ptrdiff_t>(address),
            bytes_.begin() + static_cast<std::ptrdiff_t>(address + count)};
  }
  template <typename Call>
  std::string MessageOf(const Call& call) const {
    try {
      call();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(GenicamTest, ReachesRegistersThroughReferences) {
  camera_.WriteInteger("Width", 0x218, memory_);
  EXPECT_THAT(At(0x100, 4), ElementsAre(0x18, 0x02, 0, 0));
  EXPECT_EQ(camera_.ReadInteger("Width", memory_), 0x218);
  EXPECT_EQ(camera_.ReadInteger("WidthMax", memory_), 2048);
  EXPECT_EQ(camera_.model(), "RC1");
}

TEST_F(GenicamTest, BigEndianAndSigned) {
  camera_.WriteInteger("BigReg", -2, memory_);
  EXPECT_THAT(At(0x104, 2), ElementsAre(0xff, 0xfe));
  EXPECT_EQ(camera_.ReadInteger("BigReg", memory_), -2);
}

TEST_F(GenicamTest, FieldsLeaveTheirNeighboursAlone) {
  for (std::size_t i = 0; i < 4; ++i) bytes_[0x108 + i] = 0xff;
  camera_.WriteInteger("Gain", 0x12, memory_);
  EXPECT_THAT(At(0x108, 4), ElementsAre(0x2f, 0xf1, 0xff, 0xff));
  EXPECT_EQ(camera_.ReadInteger("Gain", memory_), 0x12);
  EXPECT_EQ(camera_.ReadInteger("Tilt", memory_), -1);
  camera_.WriteInteger("Tilt", -8, memory_);
  EXPECT_EQ(camera_.ReadInteger("Tilt", memory_), -8);
  EXPECT_EQ(camera_.ReadInteger("Gain", memory_), 0x12);
  camera_.WriteInteger("BigField", 0xab, memory_);  // bits 0 to 7 counted from the highest
  EXPECT_THAT(At(0x10C, 4), ElementsAre(0xab, 0, 0, 0));
  camera_.WriteInteger("Locked", 1, memory_);
  EXPECT_THAT(At(0x110, 4), ElementsAre(8, 0, 0, 0));
}

TEST_F(GenicamTest, EnumerationsAndCommands) {
  camera_.WriteEnumeration("PixelFormat", "Coord3D_C16", memory_);
  EXPECT_THAT(At(0x118, 4), ElementsAre(0xb8, 0, 0x10, 0x01));
  EXPECT_EQ(camera_.ReadEnumeration("PixelFormat", memory_), "Coord3D_C16");
  EXPECT_THAT(camera_.Entries("PixelFormat"), ElementsAre("Coord3D_C16", "Coord3D_C32f"));
  camera_.Execute("AcquisitionStop", memory_);
  EXPECT_THAT(At(0x11C, 4), ElementsAre(2, 0, 0, 0));
}

TEST_F(GenicamTest, ConvertersGoThereAndBack) {
  bytes_[0x121] = 0x12;  // clock of 8,000,000 / s
  bytes_[0x122] = 0x7a;
  ASSERT_EQ(camera_.ReadInteger("ClockReg", memory_), 8'000'000);
  camera_.WriteFloat("ExposureTime", 250.0, memory_);
  EXPECT_EQ(camera_.ReadInteger("TicksReg", memory_), 2000);
  EXPECT_DOUBLE_EQ(camera_.ReadFloat("ExposureTime", memory_), 250.0);
  camera_.WriteInteger("Decimation", 4, memory_);
  EXPECT_EQ(camera_.ReadInteger("GuardedReg", memory_), 3);
  EXPECT_EQ(camera_.ReadInteger("Decimation", memory_), 4);
}

TEST_F(GenicamTest, FormulasOverOtherFeatures) {
  camera_.WriteInteger("Width", 64, memory_);
  camera_.WriteEnumeration("PixelFormat", "Coord3D_C32f", memory_);
  EXPECT_EQ(camera_.ReadInteger("PayloadSize", memory_), 64 * 10 * 4);
}

TEST_F(GenicamTest, AddressesThatDependOnOthers) {
  camera_.WriteEnumeration("Scan3dCoordinateSelector", "CoordinateC", memory_);
  camera_.WriteFloat("Scan3dCoordinateScale", 0.125, memory_);
  EXPECT_THAT(At(0x210, 8), ElementsAre(0, 0, 0, 0, 0, 0, 0xc0, 0x3f));
  EXPECT_EQ(camera_.ReadFloat("Scan3dCoordinateScale", memory_), 0.125);
  camera_.WriteEnumeration("Scan3dCoordinateSelector", "CoordinateA", memory_);
  EXPECT_EQ(camera_.ReadFloat("Scan3dCoordinateScale", memory_), 0.0);
  camera_.WriteFloat("OffsetReg", 1.0, memory_);
  EXPECT_THAT(At(0x220, 4), ElementsAre(0x3f, 0x80, 0, 0));
}

TEST_F(GenicamTest, TextEndsAtItsZero) {
  const std::string serial = "SN-1";
  std::copy(serial.begin(), serial.end(), bytes_.begin() + 0x40);
  EXPECT_EQ(camera_.ReadString("DeviceSerialNumber", memory_), serial);
}

TEST_F(GenicamTest, RefusesNamingTheFeature) {
  EXPECT_THAT(MessageOf([&] { camera_.WriteInteger("Width", 4096, memory_); }), HasSubstr("feature Width"));
  EXPECT_THAT(MessageOf([&] { camera_.WriteInteger("Gain", 256, memory_); }), HasSubstr("does not fit in 8 bits"));
  EXPECT_THAT(MessageOf([&] { camera_.WriteInteger("Tilt", 8, memory_); }), HasSubstr("does not fit"));
  EXPECT_THAT(MessageOf([&] { camera_.WriteInteger("ClockReg", 1, memory_); }), HasSubstr("can only be read"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadInteger("Height", memory_); }), HasSubstr("feature Height"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadInteger("Circle", memory_); }), HasSubstr("circle"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadInteger("Dangling", memory_); }), HasSubstr("NoSuchReg"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadInteger("BadFormula", memory_); }), HasSubstr("FOO"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadInteger("Struct", memory_); }), HasSubstr("StructReg"));
  EXPECT_THAT(MessageOf([&] { camera_.WriteEnumeration("PixelFormat", "Mono8", memory_); }),
              HasSubstr("Coord3D_C16, Coord3D_C32f"));
  EXPECT_THAT(MessageOf([&] { camera_.ReadEnumeration("PixelFormat", memory_); }), HasSubstr("has no name"));
  EXPECT_THAT(MessageOf([&] { camera_.Execute("Width", memory_); }), HasSubstr("no command"));
  camera_.WriteInteger("Locked", 1, memory_);
  EXPECT_THAT(MessageOf([&] { camera_.WriteInteger("Guarded", 1, memory_); }), HasSubstr("locked"));
  EXPECT_TRUE(camera_.Available("ExposureTime", memory_));
  camera_.WriteInteger("Locked", 0, memory_);
  EXPECT_FALSE(camera_.Available("ExposureTime", memory_));
  EXPECT_FALSE(camera_.Available("Height", memory_));
}

TEST_F(GenicamTest, BrokenTextIsAnError) {
  EXPECT_THROW(Description("<RegisterDescription"), DeviceError);
  EXPECT_THROW(Description("<Other/>"), DeviceError);
  EXPECT_THROW(Description(""), DeviceError);
  // Cut anywhere, it is refused or understood, never worse.
  const std::string xml = CameraXml();
  for (std::size_t length = 0; length < xml.size(); length += 97) {
    try {
      const Description cut(std::string_view(xml).substr(0, length));
      for (const char* name : {"Width", "Gain", "PayloadSize", "ExposureTime"}) {
        if (cut.Has(name)) static_cast<void>(MessageOf([&] { cut.ReadFloat(name, memory_); }));
      }
    } catch (const DeviceError&) {
    }
  }
}

TEST(GenicamFormula, Precedence) {
  const auto none = [](const std::string& name) -> std::int64_t { return name == "X" ? 5 : 0; };
  EXPECT_EQ(EvaluateInteger("1 + 2 * 3", none), 7);
  EXPECT_EQ(EvaluateInteger("(1 + 2) * 3", none), 9);
  EXPECT_EQ(EvaluateInteger("10 - 4 - 3", none), 3);
  EXPECT_EQ(EvaluateInteger("2 ** 10 - 1", none), 1023);
  EXPECT_EQ(EvaluateInteger("X <> 4 && X >= 5 ? 0xFF & ~0x0F : -1", none), 0xf0);
  EXPECT_EQ(EvaluateInteger("1 << 4 | 1", none), 17);
  EXPECT_EQ(EvaluateInteger("X = 5", none), 1);
  EXPECT_EQ(EvaluateInteger("-X % 3", none), -2);
  EXPECT_EQ(EvaluateInteger("ABS(-7) + NEG(2)", none), 5);
  const auto zero = [](const std::string&) { return 0.0; };
  EXPECT_DOUBLE_EQ(EvaluateFloat("1.5e1 / 4", zero), 3.75);
  EXPECT_DOUBLE_EQ(EvaluateFloat("SQRT(2) ** 2", zero), std::sqrt(2.0) * std::sqrt(2.0));
  for (const char* bad : {"", "1 +", "(1", "1 2", "1 / 0", "1 << 64", "@", "9999999999999999999"}) {
    EXPECT_THROW(EvaluateInteger(bad, none), std::domain_error) << bad;
  }
  EXPECT_THROW(EvaluateInteger(std::string(1000, '('), none), std::domain_error);
  EXPECT_THROW(EvaluateInteger(std::string(1000, '-') + "1", none), std::domain_error);
}

}  // namespace
}  // namespace geond::drivers::genicam
