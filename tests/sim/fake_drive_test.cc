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

using std::chrono::milliseconds;

// Between driver and drive is the kernel, and real time with it. A machine that does much else may stand still for
// seconds: no limit that a sound drive must keep is shorter.
constexpr milliseconds kReplyTime(3000);
constexpr milliseconds kPatience(10000);
// Where replies are late, the line must be silent for as long as one is waited for.
constexpr milliseconds kSilence(1000);

FakeDriveOptions Drive() {
  FakeDriveOptions options;
  options.late = 3 * kSilence / 2;
  return options;
}

drivers::ModbusTurntableOptions OptionsFor(const FakeDrive& drive, Transport transport) {
  drivers::ModbusTurntableOptions options;
  options.profile = drivers::ReadDriveProfile(std::string(GEOND_SOURCE_DIR) + "/config/drives/oriental_blv_r.toml");
  options.profile.communication_timeout_value = options.profile.lifetime = kPatience;
  options.address.response_timeout = kReplyTime;
  options.address.quiet_time = milliseconds(20);
  options.motion_timeout = options.stall_time = kPatience;
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

// For a drive whose replies may be late.
drivers::ModbusTurntableOptions Suspicious(drivers::ModbusTurntableOptions options) {
  options.address.response_timeout = kSilence;
  options.address.quiet_time = std::nullopt;
  return options;
}

class FakeDriveTest : public testing::TestWithParam<Transport> {
 protected:
  FakeDrive drive_{GetParam(), Drive()};
  ModbusTurntable table_{OptionsFor(drive_, GetParam())};

  void WaitUntilItMoves() {
    const auto begin = std::chrono::steady_clock::now();
    while (!drive_.moving() && std::chrono::steady_clock::now() - begin < kPatience) std::this_thread::yield();
  }
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
  options.speed = 0.1;  // half a minute to the target
  options.profile.communication_timeout_value = options.profile.lifetime = kReplyTime;
  ModbusTurntable table(options);
  table.Enable();
  std::thread other([&] {
    WaitUntilItMoves();
    drive_.SetFault(WireFault::kOff);  // from here on it hears nothing
  });
  EXPECT_THROW(table.MoveTo(3.0, {}), Error);
  other.join();
  const auto begin = std::chrono::steady_clock::now();
  while (drive_.moving() && std::chrono::steady_clock::now() - begin < kPatience) std::this_thread::yield();
  EXPECT_FALSE(drive_.moving());
  drive_.SetFault(WireFault::kNone);
}

TEST_P(FakeDriveTest, AHaltFromAnotherThreadStopsTheMotionAtOnce) {
  drivers::ModbusTurntableOptions options = OptionsFor(drive_, GetParam());
  options.speed = 0.1;
  ModbusTurntable table(options);
  table.Enable();
  std::thread other([&] {
    WaitUntilItMoves();
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
  options.speed = 0.1;
  ModbusTurntable table(options);
  table.Enable();
  std::stop_source stop;
  std::thread other([&] {
    WaitUntilItMoves();
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

TEST_P(FakeDriveTest, ASlowDriveIsNoFault) {
  table_.Enable();
  drive_.SetFault(WireFault::kSlow);
  EXPECT_EQ(MoveError(0.3), "");
}

TEST_P(FakeDriveTest, ALateReplyIsNeverTakenForAFreshOne) {
  ModbusTurntable table(Suspicious(OptionsFor(drive_, GetParam())));
  table.Enable();
  table.Home({});
  table.MoveTo(1.0, {});
  drive_.SetFault(WireFault::kDelayed);
  EXPECT_THROW(table.moving(), Error);  // its answer is under way now
  drive_.SetFault(WireFault::kNone);
  for (int i = 0; i < 20; ++i) {
    EXPECT_NEAR(table.angle(), 1.0, 2e-4);
    EXPECT_FALSE(table.moving());
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
  line.baud = 9600;
  line.parity = 'N';
  FakeDrive drive(Transport::kPseudoTerminal, line);
  drivers::ModbusTurntableOptions options = OptionsFor(drive, Transport::kPseudoTerminal);
  options.address.response_timeout = milliseconds(50);  // in which there is no answer
  options.address.probe_timeout = milliseconds(1500);
  ModbusTurntable table(options);
  try {
    table.Reset();
    ADD_FAILURE() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("it answers at 9600 baud with no parity"), std::string::npos) << error.what();
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

std::string NameOf(Transport transport) { return transport == Transport::kTcp ? "Tcp" : "Rtu"; }

INSTANTIATE_TEST_SUITE_P(OnTheWire, FakeDriveTest, testing::Values(Transport::kPseudoTerminal, Transport::kTcp),
                         [](const auto& param_info) { return NameOf(param_info.param); });

// One test a fault, so that their waits can pass at the same time.
class FakeDriveFault : public testing::TestWithParam<std::tuple<Transport, WireFault>> {};

TEST_P(FakeDriveFault, EndsInANamedErrorAndTheNextMotionSucceedsAfterReset) {
  const auto [transport, fault] = GetParam();
  // On TCP replies are matched by their transaction number; the unit in them means nothing.
  if (fault == WireFault::kWrongUnit && transport == Transport::kTcp) return;
  FakeDrive drive(transport, Drive());
  const drivers::ModbusTurntableOptions options = OptionsFor(drive, transport);
  ModbusTurntable table(fault == WireFault::kDelayed ? Suspicious(options) : options);
  table.Enable();
  drive.SetFault(fault);
  try {
    table.MoveTo(1.0, {});
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("turntable"), std::string::npos) << error.what();
  }
  EXPECT_EQ(table.info().state, DeviceState::kFault);
  drive.SetFault(WireFault::kNone);
  table.Reset();
  table.Enable();
  table.MoveTo(1.0, {});
  table.MoveTo(0.0, {});
}

std::string NameOf(WireFault fault) {
  switch (fault) {
    case WireFault::kOff: return "Off";
    case WireFault::kGarbage: return "Garbage";
    case WireFault::kWrong: return "Wrong";
    case WireFault::kDelayed: return "Delayed";
    case WireFault::kHalfFrame: return "HalfFrame";
    default: return "WrongUnit";
  }
}

INSTANTIATE_TEST_SUITE_P(OnTheWire, FakeDriveFault,
                         testing::Combine(testing::Values(Transport::kPseudoTerminal, Transport::kTcp),
                                          testing::Values(WireFault::kOff, WireFault::kGarbage, WireFault::kWrong,
                                                          WireFault::kDelayed, WireFault::kHalfFrame, WireFault::kWrongUnit)),
                         [](const auto& param_info) {
                           return NameOf(std::get<0>(param_info.param)) + NameOf(std::get<1>(param_info.param));
                         });

}  // namespace
}  // namespace geond::sim
