// SPDX-License-Identifier: Apache-2.0
// The driver of U3V compatible cameras against a camera seen from its endpoints: the same packets, the same failures.
#include "sim/fake_camera.h"

#include <cmath>
#include <cstring>
#include <future>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "drivers/u3v_rangefinder.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using drivers::U3vRangefinder;
using drivers::U3vRangefinderOptions;
using testing::HasSubstr;
using std::chrono::milliseconds;

constexpr int kColumns = 61, kRows = 47;  // no whole number of packets

SensorModel Sensor() {
  SensorModel sensor;
  sensor.columns = kColumns;
  sensor.rows = kRows;
  sensor.focal_u = sensor.focal_v = 420.5;
  sensor.center_u = 30.25;
  sensor.center_v = 22.5;
  sensor.min_depth = 0.25;
  sensor.max_depth = 0.75;
  sensor.depth_noise = 0.0002;
  return sensor;
}

// Every image differs from the one before; some pixels have no return.
RangeImage ImageNumber(int number, int columns = kColumns, int rows = kRows) {
  RangeImage image{columns, rows, {}};
  for (int i = 0; i < columns * rows; ++i) {
    image.depth.push_back(
        i % 7 == 0 ? NAN : 0.3f + 1e-5f * static_cast<float>(i % 1000) + 0.01f * static_cast<float>(number));
  }
  return image;
}

bool SameBits(const RangeImage& a, const RangeImage& b) {
  if (a.columns != b.columns || a.rows != b.rows) return false;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    if (std::isnan(a.depth[i]) != std::isnan(b.depth[i])) return false;
    if (!std::isnan(a.depth[i]) && std::memcmp(&a.depth[i], &b.depth[i], sizeof(float)) != 0) return false;
  }
  return true;
}

class FakeCameraTest : public testing::Test {
 protected:
  std::unique_ptr<U3vRangefinder> Open(U3vRangefinderOptions options = {}) {
    options.control.response_time = milliseconds(50);
    return std::make_unique<U3vRangefinder>([this] { return OpenFakeCamera(camera_); }, options);
  }
  Exposure TakeOne(U3vRangefinder& driver, milliseconds timeout = milliseconds(2000)) {
    driver.Trigger();
    return driver.Read(timeout, {});
  }
  std::string ErrorOf(U3vRangefinder& driver, milliseconds timeout = milliseconds(2000)) {
    try {
      TakeOne(driver, timeout);
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "no error";
  }
  U3vRangefinderOptions Floats() const {
    U3vRangefinderOptions options;
    options.pixel_format = "Coord3D_C32f";
    return options;
  }
  int taken_ = 0;
  std::shared_ptr<FakeCamera> camera_ =
      std::make_shared<FakeCamera>(Sensor(), [this] { return ImageNumber(++taken_); });
};

TEST_F(FakeCameraTest, IsFoundAndDescribedByItsOwnAccount) {
  const auto driver = Open();
  EXPECT_EQ(driver->info().serial, "FC0001");
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
  EXPECT_EQ(driver->sensor_model(), Sensor());
}

TEST_F(FakeCameraTest, FloatsArriveBitForBit) {
  const auto driver = Open(Floats());
  driver->Arm();
  EXPECT_EQ(driver->info().state, DeviceState::kArmed);
  for (int i = 1; i <= 5; ++i) EXPECT_TRUE(SameBits(TakeOne(*driver).image, ImageNumber(i))) << i;
  driver->Disarm();
  EXPECT_FALSE(camera_->acquiring());
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
}

TEST_F(FakeCameraTest, EveryFormatCarriesTheSameDepth) {
  for (const bool chunks : {false, true}) {
    camera_->SetChunks(chunks);
    for (const char* format : {"Coord3D_C16", "Coord3D_C32f", "Coord3D_ABC16", "Coord3D_ABC32f"}) {
      U3vRangefinderOptions options;
      options.pixel_format = format;
      const auto driver = Open(options);
      driver->Arm();
      for (int frame = 0; frame < 2; ++frame) {  // the second finds the stream in step
        const RangeImage image = TakeOne(*driver).image, sent = ImageNumber(taken_);
        const bool whole = std::string(format).ends_with("16");
        int wrong = 0;
        for (std::size_t i = 0; i < sent.depth.size(); ++i) {
          wrong += std::isnan(image.depth[i]) != std::isnan(sent.depth[i]);
          wrong += std::abs(image.depth[i] - sent.depth[i]) > (whole ? 1.01e-5f : 0.0f);
        }
        EXPECT_EQ(wrong, 0) << format << (chunks ? " with chunks" : "");
      }
    }
  }
}

TEST_F(FakeCameraTest, WholeNumbersArriveWithinHalfAStep) {
  const auto driver = Open();
  driver->Arm();
  const RangeImage image = TakeOne(*driver).image, sent = ImageNumber(1);
  for (std::size_t i = 0; i < sent.depth.size(); ++i) {
    ASSERT_EQ(std::isnan(image.depth[i]), std::isnan(sent.depth[i])) << i;
    if (!std::isnan(sent.depth[i])) {
      ASSERT_NEAR(image.depth[i], sent.depth[i], 1.01e-5) << i;
    }
  }
}

TEST_F(FakeCameraTest, LargeImagesInManyTransfers) {
  SensorModel sensor = Sensor();
  sensor.columns = 1024;
  sensor.rows = 1500;  // 6 MiB of floats: more than one whole transfer, less than two images under way
  camera_ = std::make_shared<FakeCamera>(sensor, [&] { return ImageNumber(++taken_, 1024, 1500); });
  const auto driver = Open(Floats());
  driver->Arm();
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(SameBits(TakeOne(*driver).image, ImageNumber(i, 1024, 1500))) << i;
}

TEST_F(FakeCameraTest, ImagesOfWholePacketsAndOfWholeTransfers) {
  for (const int columns : {256, 512}) {  // 1 KiB and 2 KiB a row of floats
    SensorModel sensor = Sensor();
    sensor.columns = columns;
    sensor.rows = columns;
    camera_ = std::make_shared<FakeCamera>(sensor, [&] { return ImageNumber(++taken_, columns, columns); });
    const auto driver = Open(Floats());
    driver->Arm();
    for (int i = 0; i < 3; ++i) {
      const RangeImage image = TakeOne(*driver).image;
      EXPECT_TRUE(SameBits(image, ImageNumber(taken_, columns, columns)));
    }
  }
}

TEST_F(FakeCameraTest, TriggeredByWire) {
  U3vRangefinderOptions options = Floats();
  options.trigger = U3vRangefinderOptions::Trigger::kWire;
  const auto driver = Open(options);
  camera_->WireTrigger();  // not armed: nothing
  driver->Arm();
  driver->Trigger();  // does nothing: the wire does
  EXPECT_THROW(driver->Read(milliseconds(5), {}), TimeoutError);
  driver->Reset();
  driver->Arm();
  camera_->WireTrigger();
  EXPECT_TRUE(SameBits(driver->Read(milliseconds(2000), {}).image, ImageNumber(1)));
}

TEST_F(FakeCameraTest, ControlFaultsAreAbsorbed) {
  const auto driver = Open(Floats());
  driver->Arm();
  const std::vector<std::pair<const char*, int FakeCameraFaults::*>> all = {
      {"stale", &FakeCameraFaults::stale_acknowledges},     {"broken", &FakeCameraFaults::broken_acknowledges},
      {"short", &FakeCameraFaults::short_acknowledges},     {"pending", &FakeCameraFaults::pending_acknowledges},
      {"busy", &FakeCameraFaults::busy_answers},            {"stall", &FakeCameraFaults::control_stalls},
      {"lost", &FakeCameraFaults::lost_acknowledges},
  };
  for (const auto& [name, fault] : all) {
    FakeCameraFaults faults;
    faults.*fault = 3;
    camera_->SetFaults(faults);
    const RangeImage image = TakeOne(*driver).image;
    EXPECT_FALSE(image.depth.empty()) << name;
    driver->Disarm();
    EXPECT_EQ(camera_->faults().*fault, 0) << name;
    EXPECT_NO_THROW(driver->Arm()) << name;
  }
}

TEST_F(FakeCameraTest, ATriggerSentTwiceLeavesNoOldImage) {
  const auto driver = Open(Floats());
  driver->Arm();
  FakeCameraFaults faults;
  faults.lost_acknowledges = 1;
  camera_->SetFaults(faults);
  TakeOne(*driver);
  ASSERT_EQ(taken_, 2);
  EXPECT_TRUE(SameBits(TakeOne(*driver).image, ImageNumber(3)));
}

TEST_F(FakeCameraTest, ACameraThatFallsSilentTimesOut) {
  const auto driver = Open();
  FakeCameraFaults faults;
  faults.silent = true;
  camera_->SetFaults(faults);
  EXPECT_THROW(driver->Arm(), TimeoutError);
  EXPECT_EQ(driver->info().state, DeviceState::kFault);
  EXPECT_THROW(driver->Arm(), DeviceError);
  camera_->SetFaults({});
  driver->Reset();
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
  driver->Arm();
  EXPECT_FALSE(TakeOne(*driver).image.depth.empty());
}

TEST_F(FakeCameraTest, EveryBrokenFrameNamesItsRuleAndTheNextScanWorks) {
  const auto driver = Open(Floats());
  const std::vector<std::tuple<int FakeCameraFaults::*, std::string>> all = {
      {&FakeCameraFaults::bad_leaders, "leader without its magic number"},
      {&FakeCameraFaults::short_payloads, "bytes for an image of"},
      {&FakeCameraFaults::overrun_trailers, "data overrun in the device"},
      {&FakeCameraFaults::wrong_blocks, "trailer of block"},
      {&FakeCameraFaults::half_images, "an image of 61 x 23 pixels where 61 x 47 were due"},
      {&FakeCameraFaults::lost_frames, "no image within 30 ms"},
  };
  for (const auto& [fault, words] : all) {
    driver->Arm();
    FakeCameraFaults faults;
    faults.*fault = 1;
    camera_->SetFaults(faults);
    EXPECT_THAT(ErrorOf(*driver, milliseconds(30)), HasSubstr(words));
    EXPECT_EQ(driver->info().state, DeviceState::kFault) << words;
    EXPECT_THROW(driver->Arm(), DeviceError) << words;
    driver->Disarm();
    EXPECT_EQ(driver->info().state, DeviceState::kFault) << words;
    driver->Reset();
    driver->Arm();
    const RangeImage image = TakeOne(*driver).image;
    EXPECT_TRUE(SameBits(image, ImageNumber(taken_))) << words;
    driver->Disarm();
  }
}

TEST_F(FakeCameraTest, OneStallIsMendedTwoAreAFault) {
  const auto driver = Open(Floats());
  driver->Arm();
  FakeCameraFaults faults;
  faults.stream_stalls = 1;
  camera_->SetFaults(faults);
  EXPECT_TRUE(SameBits(TakeOne(*driver).image, ImageNumber(2)));
  EXPECT_TRUE(SameBits(TakeOne(*driver).image, ImageNumber(3)));
  faults.stream_stalls = 2;
  camera_->SetFaults(faults);
  EXPECT_THAT(ErrorOf(*driver), HasSubstr("stalled"));
  driver->Reset();
  driver->Arm();
  const RangeImage image = TakeOne(*driver).image;
  EXPECT_TRUE(SameBits(image, ImageNumber(taken_)));
}

TEST_F(FakeCameraTest, UnpluggedAndPluggedInAgain) {
  const auto driver = Open(Floats());
  driver->Arm();
  camera_->SetPlugged(false);
  EXPECT_THAT(ErrorOf(*driver), HasSubstr("unplugged"));
  EXPECT_EQ(driver->info().state, DeviceState::kAbsent);
  driver->Disarm();
  EXPECT_THROW(driver->Reset(), DeviceError);
  EXPECT_EQ(driver->info().state, DeviceState::kAbsent);
  camera_->SetPlugged(true);
  driver->Reset();
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
  driver->Arm();
  const RangeImage image = TakeOne(*driver).image;
  EXPECT_TRUE(SameBits(image, ImageNumber(taken_)));
}

TEST_F(FakeCameraTest, CancelledWhileItWaits) {
  U3vRangefinderOptions options = Floats();
  options.trigger = U3vRangefinderOptions::Trigger::kWire;
  const auto driver = Open(options);
  driver->Arm();
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(driver->Read(milliseconds(2000), stop.get_token()), Cancelled);
  EXPECT_EQ(driver->info().state, DeviceState::kArmed);
}

TEST_F(FakeCameraTest, RefusesWhatTheCameraCannotDo) {
  U3vRangefinderOptions options;
  options.pixel_format = "Mono8";
  const auto driver = Open(options);
  EXPECT_THAT(
      [&] {
        try {
          driver->Arm();
        } catch (const DeviceError& error) {
          return std::string(error.what());
        }
        return std::string();
      }(),
      HasSubstr("Coord3D_C16, Coord3D_C32f"));
  EXPECT_THROW(driver->Trigger(), DeviceError);
  EXPECT_THROW(driver->Read(milliseconds(1), {}), DeviceError);
}

TEST_F(FakeCameraTest, TellsThatItIsUnpluggedWithoutBeingAsked) {
  const auto driver = Open();
  std::promise<void> told;
  driver->OnFault([&] { told.set_value(); });
  driver->Arm();
  camera_->SetPlugged(false);
  EXPECT_EQ(told.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
  EXPECT_EQ(driver->info().state, DeviceState::kAbsent);
  EXPECT_THAT(driver->info().fault, HasSubstr("unplugged"));
  driver->OnFault(nullptr);
  EXPECT_THROW(driver->Arm(), DeviceError);
  camera_->SetPlugged(true);
  driver->Reset();
  driver->Arm();
  EXPECT_EQ(ErrorOf(*driver), "no error");
}

TEST_F(FakeCameraTest, MayBeAbsentWhenItsDriverIsMade) {
  camera_->SetPlugged(false);
  U3vRangefinderOptions options;
  EXPECT_THROW(Open(options), DeviceError);
  options.may_be_absent = true;
  const auto driver = Open(options);
  EXPECT_EQ(driver->info().state, DeviceState::kAbsent);
  EXPECT_THROW(driver->Arm(), DeviceError);
  camera_->SetPlugged(true);
  driver->Reset();
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
}

TEST_F(FakeCameraTest, DepthsThatNoSuchCameraCanSeeAreNoImage) {
  camera_ = std::make_shared<FakeCamera>(Sensor(), [] {
    return RangeImage{kColumns, kRows, std::vector<float>(static_cast<std::size_t>(kColumns) * kRows, 50.0f)};
  });
  const auto driver = Open(Floats());
  driver->Arm();
  EXPECT_THAT(ErrorOf(*driver), HasSubstr("far out of the camera's own range"));
}

TEST_F(FakeCameraTest, AFrameMayComeLateButNotAfterItsTime) {
  camera_->SetExposureTime(milliseconds(20));
  const auto driver = Open(Floats());
  driver->Arm();
  EXPECT_EQ(ErrorOf(*driver), "no error");
  FakeCameraFaults faults;
  faults.frame_delay = std::chrono::hours(1);
  camera_->SetFaults(faults);
  EXPECT_THAT(ErrorOf(*driver, milliseconds(30)), HasSubstr("no image within"));
}

}  // namespace
}  // namespace geond::sim
