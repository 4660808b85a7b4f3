// SPDX-License-Identifier: Apache-2.0
// The driver of the wires through libgpiod against a GPIO chip at the wire: the same system calls, the same failures.
#include "drivers/gpio_lines.h"

#include <poll.h>

#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/sim/mounted_gpio_chip.h"

namespace geond::sim {
namespace {

using drivers::DeviceState;
using drivers::GpioLines;
using drivers::GpioLinesOptions;
using drivers::GpioWire;
using testing::HasSubstr;

enum Line : unsigned { kLaser, kMotor, kLamp, kTrigger, kStop, kDoor, kLines };

GpioWire At(unsigned offset, bool active_low = false) {
  GpioWire wire;
  wire.chip = MountedGpioChip::kPath;
  wire.offset = offset;
  wire.active_low = active_low;
  return wire;
}

// Emergency stop and door are loops that are closed (high) when all is well.
GpioLinesOptions Options() {
  GpioLinesOptions options;
  options.laser = At(kLaser);
  options.motor = At(kMotor);
  options.lamp = At(kLamp, true);
  options.trigger = At(kTrigger);
  options.emergency_stop = At(kStop, true);
  options.door = At(kDoor, true);
  options.debounce = std::chrono::milliseconds(1);
  options.trigger_pulse = std::chrono::microseconds(50);
  return options;
}

bool Readable(int fd, int timeout_ms) {
  pollfd descriptor{fd, POLLIN, 0};
  return poll(&descriptor, 1, timeout_ms) == 1;
}

class GpioLinesTest : public testing::Test {
 protected:
  GpioLinesTest() {
    chip_.SetInput(kStop, true);
    chip_.SetInput(kDoor, true);
  }
  FakeGpioChip chip_{kLines};
  MountedGpioChip mounted_{chip_};
};

template <typename Call>
std::string MessageOf(const Call& call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(GpioLinesTest, RequestsEveryLineSafeAndByName) {
  GpioLines lines(Options());
  for (unsigned line : {kLaser, kMotor, kTrigger}) EXPECT_FALSE(chip_.level(line)) << line;
  EXPECT_TRUE(chip_.level(kLamp));  // off is high
  for (unsigned line : {kLaser, kMotor, kLamp, kTrigger}) EXPECT_TRUE(chip_.is_output(line)) << line;
  for (unsigned line = 0; line < kLines; ++line) EXPECT_EQ(chip_.consumer(line), "geond");
  EXPECT_EQ(lines.info().state, DeviceState::kIdle);
  EXPECT_EQ(lines.info().model, "fake gpio");
}

TEST_F(GpioLinesTest, SwitchesOutputsWithTheirPolarity) {
  GpioLines lines(Options());
  lines.SetLaser(true);
  lines.SetLamp(true);
  EXPECT_TRUE(chip_.level(kLaser));
  EXPECT_FALSE(chip_.level(kLamp));
  EXPECT_TRUE(lines.laser());
  EXPECT_EQ(lines.info().state, DeviceState::kArmed);
  lines.SetMotor(true);
  lines.AllOff();
  EXPECT_FALSE(chip_.level(kLaser));
  EXPECT_FALSE(chip_.level(kMotor));
  EXPECT_FALSE(lines.laser());
  EXPECT_FALSE(lines.motor());
  EXPECT_EQ(lines.info().state, DeviceState::kIdle);
}

TEST_F(GpioLinesTest, LetsEverythingGoWhenItEnds) {
  {
    GpioLines lines(Options());
    lines.SetLaser(true);
    lines.SetMotor(true);
  }
  for (unsigned line = 0; line < kLines; ++line) EXPECT_EQ(chip_.consumer(line), "");
  EXPECT_FALSE(chip_.level(kLaser));
  EXPECT_FALSE(chip_.level(kMotor));
}

TEST_F(GpioLinesTest, PulsesTheTriggerOnce) {
  GpioLines lines(Options());
  for (int i = 1; i <= 3; ++i) {
    lines.PulseTrigger();
    EXPECT_EQ(chip_.rises(kTrigger), i);
    EXPECT_FALSE(chip_.level(kTrigger));
  }
}

TEST_F(GpioLinesTest, ReadsLevelsThatWereThereBeforeTheRequest) {
  chip_.SetInput(kStop, false);
  GpioLines lines(Options());
  EXPECT_FALSE(Readable(lines.event_fd(), 0));
  EXPECT_TRUE(lines.inputs().emergency_stop);
  EXPECT_FALSE(lines.inputs().door_open);
}

TEST_F(GpioLinesTest, TellsOfPressAndReleaseThroughItsDescriptor) {
  GpioLines lines(Options());
  EXPECT_FALSE(Readable(lines.event_fd(), 0));
  chip_.SetInput(kDoor, false);
  ASSERT_TRUE(Readable(lines.event_fd(), 0));
  EXPECT_TRUE(lines.ReadEvents().door_open);
  EXPECT_FALSE(Readable(lines.event_fd(), 0));
  chip_.SetInput(kDoor, true);
  ASSERT_TRUE(Readable(lines.event_fd(), 0));
  EXPECT_TRUE(lines.ReadEvents().door_open);  // not quiet for long enough
  ASSERT_TRUE(Readable(lines.event_fd(), 5000));
  EXPECT_FALSE(lines.ReadEvents().door_open);
}

TEST_F(GpioLinesTest, SeesAPressThatIsOverBeforeItLooks) {
  GpioLines lines(Options());
  chip_.SetInput(kStop, false);
  chip_.SetInput(kStop, true);
  ASSERT_TRUE(Readable(lines.event_fd(), 0));
  EXPECT_TRUE(lines.ReadEvents().emergency_stop);
  ASSERT_TRUE(Readable(lines.event_fd(), 5000));
  EXPECT_FALSE(lines.ReadEvents().emergency_stop);
}

TEST_F(GpioLinesTest, SurvivesMoreEdgesThanItReadsAtOnce) {
  GpioLines lines(Options());
  for (int i = 0; i < 40; ++i) chip_.SetInput(kStop, i % 2 != 0);
  EXPECT_TRUE(lines.ReadEvents().emergency_stop);
  ASSERT_TRUE(Readable(lines.event_fd(), 5000));
  EXPECT_FALSE(lines.ReadEvents().emergency_stop);
}

TEST_F(GpioLinesTest, AStuckWireIsAnError) {
  GpioLines lines(Options());
  chip_.SetStuck(true);
  EXPECT_THAT(MessageOf([&] { lines.SetLaser(true); }), HasSubstr("laser was set on but reads off. Check the wiring"));
  EXPECT_EQ(lines.info().state, DeviceState::kFault);
  chip_.SetStuck(false);
  EXPECT_THAT(MessageOf([&] { lines.SetLaser(true); }), HasSubstr("Reset the station"));
  lines.inputs();
  EXPECT_NO_THROW(lines.SetLaser(true));
}

TEST_F(GpioLinesTest, ALaserThatDoesNotGoOffIsLetGo) {
  GpioLines lines(Options());
  lines.SetLaser(true);
  chip_.SetStuck(true);
  lines.AllOff();
  EXPECT_EQ(chip_.consumer(kLaser), "");
  EXPECT_FALSE(chip_.level(kLaser));
  EXPECT_EQ(lines.info().state, DeviceState::kAbsent);
}

TEST_F(GpioLinesTest, AFailedCallNamesTheWireAndTheNextLookMends) {
  GpioLines lines(Options());
  lines.SetLaser(true);
  chip_.FailCalls(1);
  EXPECT_THAT(MessageOf([&] { lines.SetMotor(true); }),
              HasSubstr("motor, line 1 of /dev/gpiochip90: Input/output error"));
  EXPECT_FALSE(lines.motor());
  EXPECT_FALSE(lines.inputs().emergency_stop);
  EXPECT_FALSE(chip_.level(kLaser));  // asked for anew, off
  EXPECT_EQ(lines.info().state, DeviceState::kIdle);
}

TEST_F(GpioLinesTest, AChipThatVanishesTellsAtOnceAndComesBack) {
  GpioLines lines(Options());
  lines.SetLaser(true);
  chip_.Unplug();
  ASSERT_TRUE(Readable(lines.event_fd(), 0));
  EXPECT_THROW(lines.ReadEvents(), DeviceError);
  EXPECT_FALSE(Readable(lines.event_fd(), 0));  // no busy loop on a dead descriptor
  EXPECT_EQ(lines.info().state, DeviceState::kAbsent);
  EXPECT_THROW(lines.SetLaser(true), DeviceError);
  EXPECT_THROW(lines.inputs(), DeviceError);
  lines.AllOff();
  chip_.PlugIn();
  chip_.SetInput(kStop, true);
  chip_.SetInput(kDoor, true);
  EXPECT_FALSE(lines.inputs().door_open);
  EXPECT_EQ(lines.info().state, DeviceState::kIdle);
  lines.SetLaser(true);
  EXPECT_TRUE(chip_.level(kLaser));
}

TEST_F(GpioLinesTest, RefusesWhatCannotBe) {
  GpioLinesOptions options = Options();
  options.motor = At(kLaser);
  EXPECT_THROW(GpioLines{options}, std::invalid_argument);
  options = Options();
  options.motor = At(99);
  EXPECT_THAT(MessageOf([&] { GpioLines lines(options); }), HasSubstr("motor, line 99"));
  EXPECT_EQ(chip_.consumer(kLaser), "");  // what it had taken before is let go
  options = Options();
  options.laser.chip = "/dev/gpiochip91";
  EXPECT_THAT(MessageOf([&] { GpioLines lines(options); }), HasSubstr("laser, line 0 of /dev/gpiochip91"));
  GpioLines first(Options());
  EXPECT_THAT(MessageOf([&] { GpioLines second(Options()); }), HasSubstr("Another program holds the line"));
}

TEST_F(GpioLinesTest, LinesByTheirNames) {
  chip_.SetNames({"LASER", "MOTOR", "LAMP", "TRIGGER", "STOP", "DOOR"});
  GpioLinesOptions options = Options();
  options.laser.offset = 99;
  options.laser.line = "LASER";
  GpioLines lines(options);
  lines.SetLaser(true);
  EXPECT_TRUE(chip_.level(kLaser));
  options.laser.line = "LASSER";
  EXPECT_THAT(MessageOf([&] { GpioLines other(options); }), HasSubstr("laser, line LASSER of /dev/gpiochip90"));
}

TEST_F(GpioLinesTest, ASlowChipIsAFaultAndIsLetGoRatherThanWaitedFor) {
  GpioLinesOptions options = Options();
  options.longest_call = std::chrono::milliseconds(2);
  GpioLines lines(options);
  lines.SetLaser(true);
  chip_.SetSlow(std::chrono::milliseconds(10));
  EXPECT_THAT(MessageOf([&] { lines.SetMotor(true); }), HasSubstr("the chip took"));
  EXPECT_EQ(lines.info().state, DeviceState::kFault);
  lines.AllOff();
  EXPECT_FALSE(chip_.level(kLaser));
  EXPECT_FALSE(chip_.level(kMotor));
  EXPECT_EQ(chip_.consumer(kLaser), "");
  chip_.SetSlow(std::chrono::milliseconds(0));
  EXPECT_FALSE(lines.inputs().emergency_stop);
  lines.SetLaser(true);
  EXPECT_TRUE(chip_.level(kLaser));
}

TEST_F(GpioLinesTest, MayBeAbsentWhenItIsMade) {
  chip_.Unplug();
  GpioLinesOptions options = Options();
  options.may_be_absent = true;
  GpioLines lines(options);
  EXPECT_EQ(lines.info().state, DeviceState::kAbsent);
  EXPECT_THROW(lines.SetLaser(true), DeviceError);
  EXPECT_THROW(lines.inputs(), DeviceError);
  chip_.PlugIn();
  chip_.SetInput(kStop, true);
  chip_.SetInput(kDoor, true);
  EXPECT_FALSE(lines.inputs().emergency_stop);
  lines.SetLaser(true);
  EXPECT_TRUE(chip_.level(kLaser));
}

TEST_F(GpioLinesTest, WiresThatAreNotThere) {
  GpioLinesOptions options = Options();
  options.motor.reset();
  options.lamp.reset();
  options.door.reset();
  options.trigger.reset();
  GpioLines lines(options);
  lines.SetMotor(true);
  EXPECT_TRUE(lines.motor());
  lines.SetLamp(true);
  EXPECT_FALSE(lines.inputs().door_open);
  EXPECT_THAT(MessageOf([&] { lines.PulseTrigger(); }), HasSubstr("no trigger wire is configured"));
  lines.AllOff();
  EXPECT_FALSE(lines.motor());
}

}  // namespace
}  // namespace geond::sim
