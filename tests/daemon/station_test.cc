// SPDX-License-Identifier: Apache-2.0
#include "daemon/station.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "daemon/run_scan.h"
#include "tests/daemon/small_station.h"

namespace geond::daemon {
namespace {

using sim::Device;
using sim::Fault;

// The laser is off at once, the table as soon as it has braked.
void ExpectSafe(sim::SimStation& world) {
  EXPECT_FALSE(world.laser_emits());
  world.Advance(std::chrono::milliseconds(500));
  EXPECT_FALSE(world.laser_emits());
  EXPECT_FALSE(world.table_moving());
}

TEST(Station, IsSafeUntilStartedAndAfterwards) {
  const auto world = SmallWorld(32);
  {
    const OpenedStation opened = SmallStation(world);
    ExpectSafe(*world);
    {
      const ActiveStation active(*opened.station, {});
      EXPECT_TRUE(world->laser_emits());
      EXPECT_TRUE(world->motor_powered());
    }
    ExpectSafe(*world);
    EXPECT_FALSE(world->motor_powered());
    opened.station->Start({});
  }
  ExpectSafe(*world);
}

TEST(Station, ExposesWhereItWasAskedTo) {
  const auto world = SmallWorld(32);
  const OpenedStation opened = SmallStation(world);
  const ActiveStation active(*opened.station, {});
  for (const double angle : {0.5, 2.0, -1.0}) {
    const Exposure exposure = opened.station->Expose(angle, {});
    EXPECT_NEAR(std::remainder(exposure.table_angle - angle, 6.283185307179586), 0.0, 0.004);
    EXPECT_EQ(exposure.image.columns, 32);
  }
}

TEST(Station, TriggersByWire) {
  const auto world = SmallWorld(32);
  StationOptions options;
  options.trigger = StationOptions::Trigger::kWire;
  const std::unique_ptr<Station> station = SimulatedStation(world, options);
  const ActiveStation active(*station, {});
  station->Expose(0.1, {});
  EXPECT_EQ(world->trigger_count(), 1u);
}

TEST(Station, RefusesToStartWhileSomethingForbidsIt) {
  const auto world = SmallWorld(32);
  const OpenedStation opened = SmallStation(world);
  world->SetEmergencyStop(true);
  EXPECT_THROW(opened.station->Start({}), DeviceError);
  EXPECT_THROW(opened.station->Home({}), DeviceError);
  EXPECT_THROW(opened.station->Reset(), DeviceError);
  world->SetEmergencyStop(false);
  world->SetDoorOpen(true);
  EXPECT_THROW(opened.station->Start({}), DeviceError);
  ExpectSafe(*world);
  EXPECT_EQ(opened.station->Hazard(), "the door is open");
}

// The law of safety: whatever breaks and whenever, a scan ends with the laser off and the table at rest.
TEST(Station, EveryFaultOfEveryDeviceEndsSafe) {
  for (const Device device : sim::kDevices) {
    for (const Fault fault : sim::kFaults) {
      const auto world = SmallWorld(16);
      const OpenedStation opened = SmallStation(world);
      int kept = 0;
      const auto keep = [&](int view, const Exposure&) {
        ++kept;
        if (view == 1) world->SetFault(device, fault);
      };
      ScanPlan plan;
      plan.views = 4;
      SCOPED_TRACE(std::string(sim::DeviceName(device)) + " " + std::string(sim::FaultName(fault)));
      try {
        RunScan(*opened.station, plan, keep);
      } catch (const DeviceError& error) {
        EXPECT_FALSE(std::string(error.what()).empty());
      } catch (const std::invalid_argument&) {
        // so small an image may not register
      }
      EXPECT_GE(kept, 2);
      ExpectSafe(*world);
    }
  }
}

TEST(Station, EmergencyStopAndDoorAtAnyTimeEndSafe) {
  for (int i = 0; i < 40; ++i) {
    const auto world = SmallWorld(16);
    const OpenedStation opened = SmallStation(world);
    const bool door = i % 2 == 1;
    world->Schedule(std::chrono::milliseconds(1 + 173 * i), [&] {
      if (door) {
        world->SetDoorOpen(true);
      } else {
        world->SetEmergencyStop(true);
      }
    });
    ScanPlan plan;
    plan.views = 8;
    SCOPED_TRACE(i);
    try {
      RunScan(*opened.station, plan);
    } catch (const DeviceError&) {
    } catch (const std::invalid_argument&) {
    }
    ExpectSafe(*world);
  }
}

TEST(Station, CancelledAtAnyExposureIsSafeAndSaysSo) {
  for (int at = 0; at < 3; ++at) {
    const auto world = SmallWorld(16);
    const OpenedStation opened = SmallStation(world);
    std::stop_source stop;
    const auto keep = [&](int view, const Exposure&) {
      if (view == at) stop.request_stop();
    };
    ScanPlan plan;
    plan.views = 4;
    EXPECT_THROW(RunScan(*opened.station, plan, keep, stop.get_token()), Cancelled);
    ExpectSafe(*world);
  }
}

TEST(Station, IsBackAfterAFaultAndReset) {
  const auto world = SmallWorld(32);
  const OpenedStation opened = SmallStation(world);
  opened.station->Home({});
  world->SetFault(Device::kTurntable, Fault::kOff);
  EXPECT_THROW(opened.station->Start({}), DeviceError);
  EXPECT_THROW(opened.station->Reset(), DeviceError);
  world->SetFault(Device::kTurntable, Fault::kNone);
  opened.station->Reset();
  const ActiveStation active(*opened.station, {});
  EXPECT_NO_THROW(opened.station->Expose(1.0, {}));
}

TEST(RunScan, TakesOnlyTheViewsThatAreMissing) {
  const auto world = SmallWorld(48);
  const OpenedStation opened = SmallStation(world);
  ScanPlan plan;
  plan.views = 6;
  std::vector<Exposure> taken;
  const ScanResult whole = RunScan(*opened.station, plan, [&](int, const Exposure& e) { taken.push_back(e); });
  ASSERT_EQ(taken.size(), 6u);
  EXPECT_EQ(whole.views.size(), 6u);
  EXPECT_EQ(whole.scan.views.size(), 6u);
  EXPECT_TRUE(whole.scan.views[3].X_TS_refined.has_value());

  plan.taken.assign(taken.begin(), taken.begin() + 4);
  std::vector<int> again;
  RunScan(*opened.station, plan, [&](int view, const Exposure&) { again.push_back(view); });
  EXPECT_EQ(again, (std::vector<int>{4, 5}));

  // With all views there, no device is touched, and the same data give the same result.
  plan.taken = taken;
  world->SetEmergencyStop(true);
  const ScanResult same = RunScan(*opened.station, plan);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(same.registration.X_TS[i].translation(), whole.registration.X_TS[i].translation());
  }
}

}  // namespace
}  // namespace geond::daemon
