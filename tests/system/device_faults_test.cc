// SPDX-License-Identifier: Apache-2.0
// Faults at the wire in the middle of a scan by the whole service: some of what fault_matrix_validation runs in full,
// where the times are measured too. Here they are only bounded, generously, for machines that do much else.
#include <signal.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/fault_run.h"

namespace geond {
namespace {

using sim::Device;
using sim::Fault;
using testing::HasSubstr;

constexpr double kSoon = 1000.0;  // ms

void ExpectSafeAndMended(const FaultOutcome& outcome, const std::string& words) {
  EXPECT_THAT(outcome.error, HasSubstr(words));
  EXPECT_LT(outcome.to_dark, outcome.to_error + kSoon) << words;
  EXPECT_LT(outcome.to_standing, outcome.to_error + kSoon) << words;
  EXPECT_TRUE(outcome.next_scan) << words;
}

class DeviceFaults : public testing::Test {
 protected:
  void SetUp() override {
    if (kRigCannotRun) GTEST_SKIP() << "the address sanitizer cannot run below umockdev's preloaded library";
  }
};

TEST_F(DeviceFaults, EachDeviceLostAndFoundAgain) {
  HardwareRig rig({.patient = true});
  rig.Start();
  const std::pair<Device, const char*> cases[] = {
      {Device::kRangefinder, "unplugged"}, {Device::kTurntable, "no reply"}, {Device::kLines, "wires cannot be read"}};
  for (const auto& [device, words] : cases) {
    ExpectSafeAndMended(RunFault(
                            rig, [&, d = device] { rig.bench().SetFault(d, Fault::kOff); },
                            [&, d = device] { rig.bench().SetFault(d, Fault::kNone); }),
                        words);
  }
}

TEST_F(DeviceFaults, StuckAndWrong) {
  HardwareRig rig({.patient = true});
  rig.Start();
  const std::tuple<Device, Fault, const char*> cases[] = {{Device::kRangefinder, Fault::kStuck, "no image within"},
                                                          {Device::kRangefinder, Fault::kWrong, "pixels where"},
                                                          {Device::kTurntable, Fault::kStuck, "does not turn"},
                                                          {Device::kTurntable, Fault::kGarbage, "turntable"}};
  for (const auto& [device, fault, words] : cases) {
    ExpectSafeAndMended(RunFault(
                            rig, [&, d = device, f = fault] { rig.bench().SetFault(d, f); },
                            [&, d = device] { rig.bench().SetFault(d, Fault::kNone); }),
                        words);
  }
}

TEST_F(DeviceFaults, EmergencyStopAndDoorEndAScanAndWantAReset) {
  HardwareRig rig({.patient = true});
  rig.Start();
  ExpectSafeAndMended(
      RunFault(
          rig, [&] { rig.bench().SetEmergencyStop(true); }, [&] { rig.bench().SetEmergencyStop(false); }),
      "emergency stop is pressed");
  ExpectSafeAndMended(RunFault(
                          rig, [&] { rig.bench().SetDoorOpen(true); }, [&] { rig.bench().SetDoorOpen(false); }),
                      "door is open");
  // Released again is not reset.
  StartInMotion(rig);
  rig.bench().SetEmergencyStop(true);
  rig.WaitForScanEnd();
  rig.bench().SetEmergencyStop(false);
  EXPECT_THROW(rig.Call("scan.start", {{"views", 2}}), daemon::RpcError);
  EXPECT_FALSE(rig.bench().laser_shines());
}

TEST_F(DeviceFaults, AServiceKilledLeavesLaserAndMotorOffAndSafeOffTheRest) {
  HardwareRig rig({.table_speed = 20, .patient = true});
  rig.Start();
  StartInMotion(rig);
  const auto begin = std::chrono::steady_clock::now();
  rig.Kill();
  FaultOutcome outcome;
  MeasureOff(rig.bench(), begin, outcome);
  EXPECT_LT(outcome.to_dark, kSoon);
  EXPECT_LT(outcome.to_standing, kSoon);
  EXPECT_TRUE(rig.bench().camera()->acquiring());  // a camera keeps its state
  EXPECT_EQ(rig.Run({"--safe-off"}), 0) << rig.Log();
  EXPECT_FALSE(rig.bench().camera()->acquiring());
  EXPECT_FALSE(rig.bench().drive().enabled());
  // It switches the others off when one does not answer, and says so.
  rig.bench().SetFault(Device::kTurntable, Fault::kOff);
  EXPECT_EQ(rig.Run({"--safe-off"}), 1);
  EXPECT_THAT(rig.Log(), HasSubstr("turntable"));
}

TEST_F(DeviceFaults, ADriveWhoseContactorIsWeldedStopsByItsOwnTimeout) {
  HardwareRig rig({.table_speed = 20, .patient = true});
  rig.Start();
  rig.bench().BridgeMotorContact(true);
  StartInMotion(rig);
  const auto begin = std::chrono::steady_clock::now();
  rig.Kill();
  FaultOutcome outcome;
  MeasureOff(rig.bench(), begin, outcome);
  EXPECT_LT(outcome.to_standing, 3000.0 + kSoon);  // what the patient rig's profile says, and a little
}

}  // namespace
}  // namespace geond
