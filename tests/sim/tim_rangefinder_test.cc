// SPDX-License-Identifier: Apache-2.0
// The driver of line scanners against a scanner seen from its endpoints, in both of its protocols.
#include "drivers/tim_rangefinder.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "sim/fake_tim.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using drivers::TimRangefinder;
using drivers::TimRangefinderOptions;
using drivers::cola::Protocol;
using std::chrono::milliseconds;
using testing::HasSubstr;

class TimTest : public testing::TestWithParam<Protocol> {
 protected:
  std::unique_ptr<TimRangefinder> Open(int lines = 8) {
    TimRangefinderOptions options;
    options.lines = lines;
    options.columns = 91;
    options.response_time = milliseconds(100);
    return std::make_unique<TimRangefinder>([this] { return OpenFakeTim(scanner_); }, options);
  }
  std::string ErrorOf(TimRangefinder& driver) {
    try {
      driver.Trigger();
      driver.Read(milliseconds(1000), {});
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "no error";
  }
  // A flat wall across the field, a step nearer with every line.
  int taken_ = 0;
  std::shared_ptr<FakeTim> scanner_ = std::make_shared<FakeTim>(GetParam(), [this] {
    const double wall = 2.0 - 0.001 * ++taken_;
    std::vector<float> ranges;
    for (int i = 0; i < FakeTim::kReadings; ++i) {
      const double angle = (i - 135) * FakeTim::kStep;
      ranges.push_back(std::abs(angle) < 1.2 ? static_cast<float>(wall / std::cos(angle)) : NAN);
    }
    return ranges;
  });
};

TEST_P(TimTest, StacksLinesIntoAnImageWithTheirTimes) {
  const auto driver = Open();
  EXPECT_EQ(driver->info().serial, "TIM0001");
  driver->Arm();
  EXPECT_TRUE(scanner_->scanning());
  driver->Trigger();
  const int before = taken_;
  const Exposure exposure = driver->Read(milliseconds(2000), {});
  EXPECT_EQ(exposure.image.columns, 91);
  EXPECT_EQ(exposure.image.rows, 8);
  // A wall has the same depth all across, whichever way the readings point; the nearest reading is up to half a degree
  // off.
  for (int row = 0; row < 8; ++row) {
    const float middle = exposure.image.at(45, row);
    EXPECT_NEAR(middle, 2.0 - 0.001 * (before + row + 1), 0.0006);
    for (int column = 0; column < 91; ++column) EXPECT_NEAR(exposure.image.at(column, row), middle, 0.02) << column;
  }
  ASSERT_EQ(driver->line_times().size(), 8u);
  for (std::size_t i = 1; i < 8; ++i)
    EXPECT_EQ((driver->line_times()[i] - driver->line_times()[i - 1]).count(), 66'667);
  EXPECT_EQ(exposure.timestamp, driver->line_times().front());
  driver->Disarm();
  EXPECT_FALSE(scanner_->scanning());
  EXPECT_EQ(driver->info().state, DeviceState::kIdle);
}

TEST_P(TimTest, EachFaultEndsInANamedErrorAndTheNextImageSucceedsAfterReset) {
  const auto with = [](auto set) {
    FakeTimFaults faults;
    set(faults);
    return faults;
  };
  const std::vector<std::pair<FakeTimFaults, std::string>> cases = {
      {with([](FakeTimFaults& f) { f.silent = true; }), "lines came within"},
      {with([](FakeTimFaults& f) { f.unplugged = true; }), "unplugged"},
      {with([](FakeTimFaults& f) { f.status = 1; }), "error of its own"},
      {with([](FakeTimFaults& f) { f.status = 5; }), "dirty"},
      {with([](FakeTimFaults& f) { f.broken_lines = 1'000'000; }), GetParam() == Protocol::kB ? "checksum" : "ends too soon"},
  };
  const auto driver = Open();
  for (const auto& [faults, words] : cases) {
    driver->Arm();
    scanner_->SetFaults(faults);
    EXPECT_THAT(ErrorOf(*driver), HasSubstr(words));
    EXPECT_THROW(driver->Arm(), DeviceError);
    scanner_->SetFaults({});
    driver->Reset();
    driver->Arm();
    EXPECT_EQ(ErrorOf(*driver), "no error") << words;
    driver->Disarm();
  }
}

TEST_P(TimTest, LostLinesAreNoticed) {
  const auto driver = Open(40);
  driver->Arm();
  driver->Trigger();
  scanner_->SetFaults([] {
    FakeTimFaults faults;
    faults.lost_lines = 1;
    return faults;
  }());
  // The first line after a trigger has none before it that it could miss.
  std::string words;
  for (int i = 0; i < 2 && words.empty(); ++i) {
    try {
      driver->Read(milliseconds(5000), {});
      scanner_->SetFaults([] {
        FakeTimFaults faults;
        faults.lost_lines = 1;
        return faults;
      }());
    } catch (const DeviceError& error) {
      words = error.what();
    }
  }
  EXPECT_THAT(words, HasSubstr("lines were lost between"));
}

TEST_P(TimTest, RefusesAndIsSilentInWords) {
  FakeTimFaults faults;
  faults.refuses = true;
  scanner_->SetFaults(faults);
  try {
    Open();
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("refuses, error 5"));
  }
  faults = {};
  faults.silent = true;
  scanner_->SetFaults(faults);
  EXPECT_THROW(Open(), TimeoutError);
}

TEST_P(TimTest, SeesTheSceneThatTheCameraSees) {
  Scene scene;
  Geon ball;
  ball.type = GeonType::kEllipsoid;
  ball.size = {0.05, 0.05, 0.05};
  ball.X_TG = Pose::Translation({0.0, 0.0, 0.05});
  scene.parts.push_back({"ball", ball});
  const SceneGeometry geometry(scene);
  // At the height of the ball's middle, half a metre off, looking along y of T.
  Eigen::Matrix3d turn;
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Pose X_TS(turn, Eigen::Vector3d(0.0, -0.5, 0.05));
  scanner_ = std::make_shared<FakeTim>(GetParam(), [&] { return TakeScanLine(geometry, X_TS); });
  const auto driver = Open(2);
  driver->Arm();
  driver->Trigger();
  const Exposure exposure = driver->Read(milliseconds(2000), {});
  EXPECT_NEAR(exposure.image.at(45, 0), 0.45, 0.001);
  EXPECT_EQ(exposure.image.at(45, 0), exposure.image.at(45, 1));
}

TEST_P(TimTest, EndsOnAStopRequest) {
  const auto driver = Open();
  driver->Arm();
  FakeTimFaults faults;
  faults.silent = true;
  scanner_->SetFaults(faults);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(driver->Read(milliseconds(2000), stop.get_token()), Cancelled);
}

INSTANTIATE_TEST_SUITE_P(InBothProtocols, TimTest, testing::Values(Protocol::kA, Protocol::kB),
                         [](const auto& param_info) { return param_info.param == Protocol::kA ? "ColaA" : "ColaB"; });

}  // namespace
}  // namespace geond::sim
