// SPDX-License-Identifier: Apache-2.0
// The Modbus driver against a drive at the wire: the same requests, the same system calls, the same failures.
#include "sim/fake_drive.h"

#include <cmath>
#include <future>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "drivers/modbus_turntable.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using drivers::ModbusTurntable;
using Transport = FakeDrive::Transport;

drivers::ModbusTurntableOptions OptionsFor(const FakeDrive& drive, Transport transport) {
  drivers::ModbusTurntableOptions options;
  options.profile = drivers::ReadDriveProfile(std::string(GEOND_SOURCE_DIR) + "/config/drives/oriental_blv_r.toml");
  if (transport == Transport::kPseudoTerminal) {
    options.address.serial_device = drive.serial_device();
  } else {
    options.address.host = "127.0.0.1";
    options.address.port = drive.port();
  }
  options.speed = 20.0;  // quick: these tests run in real time
  options.acceleration = 100.0;
  options.settle_time = std::chrono::milliseconds(1);
  return options;
}

class FakeDriveTest : public testing::TestWithParam<Transport> {
 protected:
  FakeDrive drive_{GetParam()};
  ModbusTurntable table_{OptionsFor(drive_, GetParam())};

  std::string MoveError(double angle) {
    try {
      table_.MoveTo(angle, {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_P(FakeDriveTest, HomesAndGoesTheShortestWayToEachAngle) {
  table_.Enable();
  EXPECT_TRUE(drive_.enabled());
  EXPECT_EQ(table_.info().state, DeviceState::kArmed);
  table_.Home({});
  EXPECT_NEAR(table_.angle(), 0.0, 1e-9);
  for (const double angle : {0.5, -0.5, 3.0, -3.0, 0.0}) {  // 3.0 to -3.0 leads over pi, not back over zero
    const double before = table_.angle();
    table_.MoveTo(angle, {});
    EXPECT_NEAR(std::remainder(table_.angle() - angle, 2.0 * std::numbers::pi), 0.0, 2e-4);
    EXPECT_LE(std::abs(table_.angle() - before), std::numbers::pi + 1e-3);
    EXPECT_FALSE(table_.moving());
  }
  table_.Disable();
  EXPECT_FALSE(drive_.enabled());
}

TEST_P(FakeDriveTest, TheDriveStopsByItselfWhenNothingIsSaidToIt) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.speed = 0.5;
  ModbusTurntable table(options);
  table.Enable();
  std::thread other([&] {
    while (!drive_.moving()) std::this_thread::yield();
    drive_.SetFault(WireFault::kOff);  // from here on it hears nothing
  });
  EXPECT_THROW(table.MoveTo(3.0, {}), Error);
  other.join();
  const auto begin = std::chrono::steady_clock::now();
  while (drive_.moving() && std::chrono::steady_clock::now() - begin < std::chrono::seconds(5)) std::this_thread::yield();
  EXPECT_FALSE(drive_.moving());
  drive_.SetFault(WireFault::kNone);
}

TEST_P(FakeDriveTest, AHaltFromAnotherThreadStopsTheMotionAtOnce) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.speed = 0.5;
  ModbusTurntable table(options);
  table.Enable();
  std::thread other([&] {
    while (!drive_.moving()) std::this_thread::yield();
    table.Halt();
  });
  EXPECT_THROW(table.MoveTo(3.0, {}), DeviceError);
  other.join();
  EXPECT_FALSE(drive_.moving());
  EXPECT_EQ(table.info().state, DeviceState::kFault);
  table.Reset();
  table.MoveTo(table.angle() + 0.01, {});
}

TEST_P(FakeDriveTest, CancellingAMotionLeavesTheTableStanding) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.speed = 0.5;
  ModbusTurntable table(options);
  table.Enable();
  std::stop_source stop;
  std::thread other([&] {
    while (!drive_.moving()) std::this_thread::yield();
    stop.request_stop();
  });
  EXPECT_THROW(table.MoveTo(3.0, stop.get_token()), Cancelled);
  other.join();
  EXPECT_FALSE(drive_.moving());
}

TEST_P(FakeDriveTest, AnAlarmComesInTheDrivesOwnWordsAndStaysUntilReset) {
  table_.Enable();
  drive_.RaiseAlarm(0x30);
  const std::string error = MoveError(1.0);
  EXPECT_NE(error.find("30h (overload)"), std::string::npos) << error;
  EXPECT_NE(MoveError(1.0).find("Reset it first"), std::string::npos);
  table_.Reset();
  table_.Enable();
  EXPECT_EQ(MoveError(1.0), "");
}

TEST_P(FakeDriveTest, EachFaultEndsInANamedErrorAndTheNextMotionSucceedsAfterReset) {
  for (const WireFault fault : {WireFault::kOff, WireFault::kGarbage, WireFault::kWrong, WireFault::kDelayed, WireFault::kHalfFrame,
                                WireFault::kWrongUnit}) {
    // On TCP replies are matched by their transaction number; the unit in them means nothing.
    if (fault == WireFault::kWrongUnit && GetParam() == Transport::kTcp) continue;
    table_.Enable();
    drive_.SetFault(fault);
    const auto begin = std::chrono::steady_clock::now();
    const std::string error = MoveError(1.0);
    EXPECT_NE(error.find("turntable"), std::string::npos) << static_cast<int>(fault);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
    EXPECT_EQ(table_.info().state, DeviceState::kFault);
    drive_.SetFault(WireFault::kNone);
    table_.Reset();
    table_.Enable();
    EXPECT_EQ(MoveError(1.0), "") << static_cast<int>(fault);
    EXPECT_EQ(MoveError(0.0), "") << static_cast<int>(fault);
  }
}

TEST_P(FakeDriveTest, ASlowDriveIsNoFault) {
  table_.Enable();
  drive_.SetFault(WireFault::kSlow);
  EXPECT_EQ(MoveError(0.3), "");
}

TEST_P(FakeDriveTest, ALateReplyIsNeverTakenForAFreshOne) {
  table_.Enable();
  table_.Home({});
  table_.MoveTo(1.0, {});
  drive_.SetFault(WireFault::kDelayed);
  EXPECT_THROW(table_.moving(), Error);  // its answer is under way now
  drive_.SetFault(WireFault::kNone);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(table_.angle(), 1.0, 2e-4);
    EXPECT_FALSE(table_.moving());
  }
}

TEST_P(FakeDriveTest, AStuckMotorIsATimeout) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.motion_timeout = std::chrono::milliseconds(100);
  ModbusTurntable table(options);
  table.Enable();
  drive_.SetFault(WireFault::kStuck);
  EXPECT_THROW(table.MoveTo(1.0, {}), TimeoutError);
}

TEST_P(FakeDriveTest, AMotorThatDoesNotTurnIsNamedBeforeItsTimeIsOver) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.stall_time = std::chrono::milliseconds(30);
  options.motion_timeout = std::chrono::seconds(60);
  ModbusTurntable table(options);
  table.Enable();
  drive_.SetPower(false);  // as by its contactor
  try {
    table.MoveTo(1.0, {});
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("the motor does not turn"), std::string::npos) << error.what();
  }
  drive_.SetPower(true);
  table.Reset();
  table.Enable();
  table.Home({});
}

TEST_P(FakeDriveTest, ACrawlingMotorDoesNotArriveInTime) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.motion_timeout = std::chrono::milliseconds(100);
  ModbusTurntable table(options);
  table.Enable();
  drive_.SetFault(WireFault::kCrawling);
  EXPECT_THROW(table.MoveTo(3.0, {}), TimeoutError);
}

TEST_P(FakeDriveTest, TellsOfALossThatNobodyAskedAbout) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.watch_period = std::chrono::milliseconds(2);
  ModbusTurntable table(options);
  std::promise<void> told;
  table.OnFault([&] { told.set_value(); });
  table.Enable();
  drive_.SetFault(WireFault::kOff);
  EXPECT_EQ(told.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
  EXPECT_NE(table.info().fault.find("no reply"), std::string::npos) << table.info().fault;
  table.OnFault(nullptr);
}

TEST(FakeDrive, ADriveThatAnswersAtOtherSettingsOfTheLineIsFoundOut) {
  FakeDriveOptions line;
  line.baud = 19200;
  line.parity = 'N';
  FakeDrive drive(Transport::kPseudoTerminal, line);
  ModbusTurntable table(OptionsFor(drive, Transport::kPseudoTerminal));
  try {
    table.Reset();
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("it answers at 19200 baud with no parity"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("turntable.parity"), std::string::npos) << error.what();
  }
}

TEST_P(FakeDriveTest, RefusesTargetsBeyondTheSoftLimits) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.max_angle = 0.5;
  ModbusTurntable table(options);
  table.Enable();
  table.Home({});
  EXPECT_THROW(table.MoveTo(1.0, {}), std::invalid_argument);
  EXPECT_EQ(table.info().state, DeviceState::kArmed);
}

TEST_P(FakeDriveTest, ALostConnectionIsNamed) {
  table_.Enable();
  drive_.Unplug();
  std::string error;
  for (int i = 0; i < 200 && error.empty(); ++i) {
    try {
      table_.angle();
    } catch (const Error& caught) {
      error = caught.what();
    }
  }
  EXPECT_NE(error.find("turntable"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(OnTheWire, FakeDriveTest, testing::Values(Transport::kPseudoTerminal, Transport::kTcp),
                         [](const auto& param_info) { return param_info.param == Transport::kTcp ? "Tcp" : "Rtu"; });

}  // namespace
}  // namespace geond::sim
