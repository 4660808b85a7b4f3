// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_devices.h"

#include <poll.h>

#include <cmath>
#include <functional>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180.0;

StationOptions Options() {
  StationOptions options;
  options.assumed = MakeStation(0.45, 0.489, 0.05, 48, 48);
  options.threads = 1;
  return options;
}

Scene Ball() {
  Scene scene;
  scene.parts.push_back(
      {"ball", {GeonType::kEllipsoid, Pose::Translation({0, 0, 0.05}), {0.05, 0.05, 0.05}, {0, 0}, 0}});
  return scene;
}

class SimDevices : public testing::Test {
 protected:
  // Ready to scan: power on, laser on, table homed, sensor armed.
  void MakeReady() {
    lines_.SetMotor(true);
    lines_.SetLaser(true);
    table_.Enable();
    table_.Home({});
    range_.Arm();
  }
  std::string Failure(const std::function<void()>& call) {
    try {
      call();
    } catch (const TimeoutError& error) {
      return std::string("timeout: ") + error.what();
    } catch (const DeviceError& error) {
      return std::string("device: ") + error.what();
    }
    return "nothing failed";
  }
  std::shared_ptr<SimStation> station_ = std::make_shared<SimStation>(Ball(), Options());
  SimRangefinder range_{station_};
  SimTurntable table_{station_};
  SimLines lines_{station_};
};

TEST_F(SimDevices, AScanOfFourViewsGoesThroughInSimulatedTime) {
  MakeReady();
  SimStation::Time last{0};
  for (int i = 0; i < 4; ++i) {
    table_.MoveTo(i * 90.0 * kDegree, {});
    EXPECT_NEAR(std::remainder(table_.angle() - i * 90.0 * kDegree, 2.0 * std::numbers::pi), 0.0, 0.001);
    range_.Trigger();
    const Exposure exposure = range_.Read(milliseconds(200), {});
    EXPECT_EQ(exposure.image.columns, 48);
    EXPECT_GT(exposure.timestamp, last);
    last = exposure.timestamp;
  }
  EXPECT_EQ(range_.info().state, DeviceState::kArmed);
  EXPECT_GT(station_->now(), seconds(5));
  EXPECT_LT(station_->now(), seconds(30));
}

TEST_F(SimDevices, NoFrameWithoutLaserOrTrigger) {
  MakeReady();
  const SimStation::Time before = station_->now();
  EXPECT_THAT(Failure([&] { range_.Read(milliseconds(200), {}); }), HasSubstr("timeout"));
  EXPECT_EQ(station_->now() - before, milliseconds(200));
  EXPECT_EQ(range_.info().state, DeviceState::kFault);
  EXPECT_THAT(Failure([&] { range_.Arm(); }), HasSubstr("Reset it first"));
  range_.Reset();
  range_.Arm();
  lines_.SetLaser(false);
  range_.Trigger();
  EXPECT_THAT(Failure([&] { range_.Read(milliseconds(200), {}); }), HasSubstr("timeout"));
}

TEST_F(SimDevices, TheTriggerWireTriggersTheSensorThatListensToIt) {
  lines_.SetLaser(true);
  SimRangefinder by_wire(station_, SimRangefinder::TriggerSource::kWire);
  by_wire.Arm();
  by_wire.Trigger();
  EXPECT_THAT(Failure([&] { by_wire.Read(milliseconds(100), {}); }), HasSubstr("timeout"));
  by_wire.Reset();
  by_wire.Arm();
  lines_.PulseTrigger();
  EXPECT_EQ(by_wire.Read(milliseconds(100), {}).image.rows, 48);
}

TEST_F(SimDevices, EmergencyStopInMotionCutsPowerAndLaserAndIsNamed) {
  MakeReady();
  const SimStation::Time begin = station_->now();
  station_->Schedule(milliseconds(700), [&] { station_->SetEmergencyStop(true); });
  EXPECT_THAT(Failure([&] { table_.MoveTo(120 * kDegree, {}); }), HasSubstr("lost its power"));
  EXPECT_LE(station_->now() - begin, milliseconds(720));
  EXPECT_FALSE(station_->laser_emits());
  station_->Advance(milliseconds(80));
  EXPECT_FALSE(station_->table_moving());
  EXPECT_TRUE(lines_.inputs().emergency_stop);
  EXPECT_EQ(table_.info().state, DeviceState::kFault);
  station_->SetEmergencyStop(false);
  table_.Reset();
  table_.Enable();
  table_.Home({});
  table_.MoveTo(120 * kDegree, {});
}

TEST_F(SimDevices, AnOpenDoorStopsTheLaser) {
  MakeReady();
  EXPECT_TRUE(station_->laser_emits());
  station_->SetDoorOpen(true);
  EXPECT_FALSE(station_->laser_emits());
  EXPECT_TRUE(lines_.inputs().door_open);
}

TEST_F(SimDevices, InputChangesWakeTheEventDescriptor) {
  pollfd waiting{lines_.event_fd(), POLLIN, 0};
  EXPECT_EQ(poll(&waiting, 1, 0), 0);
  station_->SetDoorOpen(true);
  EXPECT_EQ(poll(&waiting, 1, 0), 1);
  EXPECT_TRUE(lines_.ReadEvents().door_open);
  EXPECT_EQ(poll(&waiting, 1, 0), 0);
}

TEST_F(SimDevices, CancellingAMoveLeavesTheTableStanding) {
  MakeReady();
  std::stop_source stop;
  station_->Schedule(milliseconds(500), [&] { stop.request_stop(); });
  EXPECT_THROW(table_.MoveTo(170 * kDegree, stop.get_token()), Cancelled);
  EXPECT_FALSE(station_->table_moving());
  EXPECT_LT(station_->table_angle(), 60 * kDegree);
  table_.MoveTo(10 * kDegree, {});
}

TEST_F(SimDevices, HaltFromOutsideEndsTheMove) {
  MakeReady();
  station_->Schedule(milliseconds(500), [&] { table_.Halt(); });
  EXPECT_THAT(Failure([&] { table_.MoveTo(170 * kDegree, {}); }), HasSubstr("halted"));
  EXPECT_FALSE(station_->table_moving());
}

TEST_F(SimDevices, TheTableGoesTheShortWayAndOnlyAfterHoming) {
  lines_.SetMotor(true);
  table_.Enable();
  EXPECT_THAT(Failure([&] { table_.MoveTo(1.0, {}); }), HasSubstr("Home it first"));
  table_.Home({});
  table_.MoveTo(170 * kDegree, {});
  const SimStation::Time before = station_->now();
  table_.MoveTo(-170 * kDegree, {});
  EXPECT_LT(station_->now() - before, seconds(1));
  EXPECT_NEAR(station_->motor_angle(), 190 * kDegree, 1e-9);
  lines_.SetMotor(false);
  EXPECT_THAT(Failure([&] { SimTurntable(station_).Enable(); }), HasSubstr("no power"));
}

struct Cell {
  Device device;
  Fault fault;
  std::string shows;  // a part of the message; empty: nothing fails
};
void PrintTo(const Cell& cell, std::ostream* out) { *out << DeviceName(cell.device) << " " << FaultName(cell.fault); }

class SimFaults : public SimDevices, public testing::WithParamInterface<Cell> {
 protected:
  // What every device does in one step of a scan.
  void OneStep() {
    const auto inputs = lines_.inputs();
    if (inputs.emergency_stop || inputs.door_open) throw DeviceError("lines", "inputs", "emergency stop or door");
    lines_.SetLaser(true);
    table_.MoveTo(30 * kDegree, {});
    lines_.SetLaser(false);
    lines_.SetLaser(true);
    range_.Trigger();
    range_.Read(milliseconds(900), {});
    range_.Trigger();
    range_.Read(milliseconds(900), {});
  }
};

TEST_P(SimFaults, ShowsSwitchesAtRunTimeAndIsGoneAfterReset) {
  MakeReady();
  OneStep();
  table_.MoveTo(0, {});
  station_->SetFault(GetParam().device, GetParam().fault);
  const SimStation::Time before = station_->now();
  const std::string failure = Failure([&] { OneStep(); });
  EXPECT_THAT(failure, HasSubstr(GetParam().shows.empty() ? "nothing failed" : GetParam().shows));
  EXPECT_LT(station_->now() - before, seconds(6));
  // Mended and reset, all works again.
  station_->SetFault(GetParam().device, Fault::kNone);
  range_.Reset();
  table_.Reset();
  MakeReady();
  OneStep();
}

INSTANTIATE_TEST_SUITE_P(
    All, SimFaults,
    testing::Values(
        Cell{Device::kRangefinder, Fault::kOff, "does not answer"},
        Cell{Device::kRangefinder, Fault::kStuck, "no frame came within 900 ms"},
        Cell{Device::kRangefinder, Fault::kGarbage, "depths are no number"},
        Cell{Device::kRangefinder, Fault::kWrong, "the frame is 48 x 24"}, Cell{Device::kRangefinder, Fault::kSlow, ""},
        Cell{Device::kRangefinder, Fault::kDelayed, "no frame came within 900 ms"},
        Cell{Device::kRangefinder, Fault::kIntermittent, "no frame came within 900 ms"},
        Cell{Device::kTurntable, Fault::kOff, "does not answer"},
        Cell{Device::kTurntable, Fault::kStuck, "did not arrive in time"},
        Cell{Device::kTurntable, Fault::kGarbage, "checksum"}, Cell{Device::kTurntable, Fault::kWrong, "stands at 40"},
        Cell{Device::kTurntable, Fault::kSlow, "did not arrive in time"},
        Cell{Device::kTurntable, Fault::kDelayed, "no reply came within 1000 ms"},
        Cell{Device::kTurntable, Fault::kIntermittent, ""}, Cell{Device::kLines, Fault::kOff, "the chip is gone"},
        Cell{Device::kLines, Fault::kStuck, "set laser"}, Cell{Device::kLines, Fault::kGarbage, "inputs change faster"},
        Cell{Device::kLines, Fault::kWrong, "emergency stop or door"}, Cell{Device::kLines, Fault::kSlow, ""},
        Cell{Device::kLines, Fault::kDelayed, ""}, Cell{Device::kLines, Fault::kIntermittent, "the request failed"}));

TEST_F(SimDevices, IntermittentTableLosesEveryThirdRequest) {
  MakeReady();
  station_->SetFault(Device::kTurntable, Fault::kIntermittent);
  EXPECT_THAT(Failure([&] {
                for (int i = 0; i < 3; ++i) table_.angle();
              }),
              HasSubstr("unanswered"));
}

TEST_F(SimDevices, DelayedLinesShowAnInputOneSecondLate) {
  station_->SetFault(Device::kLines, Fault::kDelayed);
  station_->SetDoorOpen(true);
  EXPECT_FALSE(lines_.inputs().door_open);
  station_->Advance(milliseconds(1001));
  EXPECT_TRUE(lines_.inputs().door_open);
}

TEST_F(SimDevices, LinesThatFailReleaseLaserAndMotor) {
  MakeReady();
  station_->SetFault(Device::kLines, Fault::kOff);
  EXPECT_FALSE(station_->laser_emits());
  EXPECT_FALSE(station_->motor_powered());
  lines_.AllOff();
}

TEST(SimStation, SameSeedSameScan) {
  const auto scan = [] {
    auto station = std::make_shared<SimStation>(Ball(), Options());
    SimLines lines(station);
    SimTurntable table(station);
    SimRangefinder range(station);
    lines.SetMotor(true);
    lines.SetLaser(true);
    table.Enable();
    table.Home({});
    range.Arm();
    std::vector<double> values;
    for (int i = 0; i < 3; ++i) {
      table.MoveTo(i * 2.0, {});
      values.push_back(table.angle());
      range.Trigger();
      for (const float depth : range.Read(milliseconds(100), {}).image.depth) {
        values.push_back(std::isnan(depth) ? -1.0 : depth);
      }
    }
    return values;
  };
  EXPECT_EQ(scan(), scan());
}

TEST(FaultWords, RoundTripAndRefuse) {
  for (const Fault fault : kFaults) EXPECT_EQ(FaultFromName(FaultName(fault)), fault);
  for (const Device device : kDevices) EXPECT_EQ(DeviceFromName(DeviceName(device)), device);
  EXPECT_THROW(FaultFromName("broken"), std::invalid_argument);
}

}  // namespace
}  // namespace geond::sim
