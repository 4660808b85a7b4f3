// SPDX-License-Identifier: Apache-2.0
// The driver through libusb. The outer tests start this program again below fake_camera_usb, which plugs in a fake
// camera; the inner ones (UsbCameraInside) run there. A foreign client, Aravis, then proves the fake.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "drivers/libusb_port.h"
#include "drivers/u3v_rangefinder.h"
#include "sim/range_camera.h"
#include "sim/scene.h"

namespace geond::sim {
namespace {

namespace fs = std::filesystem;
using drivers::DeviceState;
using drivers::U3vRangefinder;
using drivers::U3vRangefinderOptions;
using std::chrono::milliseconds;
using testing::HasSubstr;

constexpr int kColumns = 96, kRows = 80;
constexpr milliseconds kPatience(2000);  // with a machine that does much else
const std::string kScene = std::string(GEOND_SOURCE_DIR) + "/config/scenes/mug.toml";

std::string Program() { return fs::read_symlink("/proc/self/exe").string(); }
std::string FakePort() { return (fs::path(Program()).parent_path() / "fake_camera_usb").string(); }

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

struct Outcome {
  int status = -1;
  std::string output;
};

Outcome RunBelowFakePort(const std::string& control, const std::string& command) {
  const std::string line = FakePort() + " " + kScene + " " + std::to_string(kColumns) + " " + std::to_string(kRows) +
                           " " + control + " " + command + " 2>&1";
  Outcome outcome;
  FILE* pipe = popen(line.c_str(), "r");
  if (pipe == nullptr) return outcome;
  std::array<char, 4096> text{};
  while (fgets(text.data(), text.size(), pipe) != nullptr) outcome.output += text.data();
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

class UsbCamera : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(FakePort())) GTEST_SKIP() << "umockdev was not there when this was built: no fake USB port";
    if (kSanitized) GTEST_SKIP() << "the address sanitizer cannot run below umockdev's preloaded library";
  }
};

TEST_F(UsbCamera, TheDriverThroughLibusb) {
  const std::string control = testing::TempDir() + "fake_camera_orders_" + std::to_string(getpid());
  setenv("GEOND_FAKE_CAMERA_ORDERS", control.c_str(), 1);
  const Outcome outcome = RunBelowFakePort(control, Program() + " --gtest_filter='UsbCameraInside.*'");
  unsetenv("GEOND_FAKE_CAMERA_ORDERS");
  fs::remove(control);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("[  PASSED  ] 4 tests"));
}

TEST_F(UsbCamera, AForeignClientFindsItAndReadsItsFeatures) {
  if (!fs::exists("/usr/bin/arv-tool-0.8")) GTEST_SKIP() << "arv-tool-0.8 (package aravis-tools-cli) is not installed";
  const Outcome list = RunBelowFakePort("-", "arv-tool-0.8");
  EXPECT_THAT(list.output, HasSubstr("geond-GEON00FC0001-FC0001 (USB3)"));
  const Outcome features = RunBelowFakePort("-", "arv-tool-0.8 control Width Height PixelFormat DeviceModelName");
  EXPECT_THAT(features.output, HasSubstr("Width = 96")) << features.output;
  EXPECT_THAT(features.output, HasSubstr("PixelFormat = Coord3D_C16"));
}

class UsbCameraInside : public testing::Test {
 protected:
  void SetUp() override {
    const char* orders = std::getenv("GEOND_FAKE_CAMERA_ORDERS");
    if (orders == nullptr) GTEST_SKIP() << "runs below fake_camera_usb only";
    orders_ = orders;
  }
  void Order(const std::string& words) { std::ofstream(orders_) << words << std::endl; }
  std::unique_ptr<U3vRangefinder> Open() {
    U3vRangefinderOptions options;
    options.pixel_format = "Coord3D_C32f";
    options.control.response_time = kPatience;
    return std::make_unique<U3vRangefinder>(drivers::LibusbCamera(""), options);
  }
  Exposure TakeOne(U3vRangefinder& driver) {
    driver.Trigger();
    return driver.Read(5 * kPatience, {});
  }
  std::string orders_;
};

bool SameBits(const RangeImage& a, const RangeImage& b) {
  if (a.columns != b.columns || a.rows != b.rows) return false;
  for (std::size_t i = 0; i < a.depth.size(); ++i) {
    if (std::isnan(a.depth[i]) != std::isnan(b.depth[i])) return false;
    if (!std::isnan(a.depth[i]) && std::memcmp(&a.depth[i], &b.depth[i], sizeof(float)) != 0) return false;
  }
  return true;
}

// Runs first, so that the fake's images are numbered from 0.
TEST_F(UsbCameraInside, AImagesAreTheSimulatedOnesBitForBit) {
  const StationGeometry station = MakeStation(0.450, 0.489, 0.060, kColumns, kRows);
  const SceneGeometry scene(ReadScene(kScene));
  const Pose X_TS = SensorInTurntable(station, 0.0);
  const auto driver = Open();
  EXPECT_EQ(driver->info().serial, "GEON00FC0001");
  EXPECT_EQ(driver->info().model, "FakeRange");
  EXPECT_EQ(driver->sensor_model().columns, kColumns);
  EXPECT_EQ(driver->sensor_model().focal_u, station.sensor.focal_u);
  driver->Arm();
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    const RangeImage expected = TakeRangeImage(scene, station.sensor, X_TS, CameraOptions{}, 1, frame, 1);
    EXPECT_TRUE(SameBits(TakeOne(*driver).image, expected)) << frame;
  }
}

TEST_F(UsbCameraInside, BFaultsAtTheWire) {
  const auto driver = Open();
  driver->Arm();
  TakeOne(*driver);
  const std::array<std::pair<const char*, const char*>, 2> rejected = {
      {{"overrun", "data overrun in the device"}, {"bad_leader", "leader without its magic number"}}};
  for (const auto& [order, words] : rejected) {
    // The order travels beside the wire: take images until it has arrived.
    Order(order);
    std::string message;
    for (int i = 0; i < 1000 && message.empty(); ++i) {
      try {
        TakeOne(*driver);
      } catch (const DeviceError& error) {
        message = error.what();
      }
    }
    EXPECT_THAT(message, HasSubstr(words));
    driver->Reset();
    driver->Arm();
    TakeOne(*driver);
  }
  Order("stall");
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(TakeOne(*driver).image.depth.empty());  // mended on the way
  Order("lose_acknowledge");
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(TakeOne(*driver).image.depth.empty());
}

TEST_F(UsbCameraInside, CTriggeredByWire) {
  U3vRangefinderOptions options;
  options.trigger = U3vRangefinderOptions::Trigger::kWire;
  options.control.response_time = kPatience;
  U3vRangefinder driver(drivers::LibusbCamera("FC0001"), options);
  driver.Arm();
  EXPECT_THROW(driver.Read(milliseconds(20), {}), TimeoutError);
  driver.Reset();
  driver.Arm();
  Order("trigger");
  EXPECT_FALSE(driver.Read(5 * kPatience, {}).image.depth.empty());
  EXPECT_THROW(drivers::LibusbCamera("NOBODY")(), DeviceError);
}

TEST_F(UsbCameraInside, DUnpluggedWhileItWaitsAndPluggedInAgain) {
  U3vRangefinderOptions options;
  options.trigger = U3vRangefinderOptions::Trigger::kWire;
  options.control.response_time = kPatience;
  U3vRangefinder driver(drivers::LibusbCamera(""), options);
  driver.Arm();
  Order("unplug");
  try {
    driver.Read(5 * kPatience, {});
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("unplugged"));
  }
  EXPECT_EQ(driver.info().state, DeviceState::kAbsent);
  driver.Disarm();
  Order("plug");
  bool back = false;
  for (int i = 0; i < 2000 && !back; ++i) {
    try {
      driver.Reset();
      back = true;
    } catch (const DeviceError&) {
    }
  }
  ASSERT_TRUE(back);
  driver.Arm();
  Order("trigger");
  EXPECT_FALSE(driver.Read(5 * kPatience, {}).image.depth.empty());
}

}  // namespace
}  // namespace geond::sim
