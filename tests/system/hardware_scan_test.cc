// SPDX-License-Identifier: Apache-2.0
// The service on real drivers over wires (libusb, libmodbus, libgpiod) whose other ends are fakes, against the service
// on the twins of the same station.
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/scan_store.h"
#include "tests/support/hardware_rig.h"

namespace geond {
namespace {

using daemon::Json;
using testing::HasSubstr;

struct Taken {
  std::vector<Exposure> exposures;
  Json description;
};

// Starts a scan, keeps its images as they come to disk, and waits for what is said of the object.
Taken ScanOn(HardwareRig& rig, int views) {
  Taken taken;
  const int scan = rig.Call("scan.start", {{"views", views}})["scan"];
  while (rig.WaitForEvent("view")["view"] != views - 1) {
  }
  taken.exposures = daemon::ScanRecorder(rig.ScanFolder(scan)).Views();  // raw, before the scan is packed
  const Json end = rig.WaitForScanEnd();
  EXPECT_EQ(end["state"], "done") << end << rig.Log();
  if (end["state"] == "done") taken.description = rig.Call("object.describe", {{"scan", scan}});
  return taken;
}

void ExpectSameNumbers(const Json& a, const Json& b, const std::string& where) {
  ASSERT_EQ(a.is_number(), b.is_number()) << where;
  if (a.is_number()) {
    EXPECT_NEAR(a.get<double>(), b.get<double>(), 1e-6 * (1.0 + std::abs(b.get<double>()))) << where;
  } else if (a.is_structured()) {
    ASSERT_EQ(a.size(), b.size()) << where;
    for (const auto& [key, value] : a.items()) {
      if (key == "seconds") continue;  // how long it took
      ExpectSameNumbers(value, a.is_array() ? b[std::stoul(key)] : b.at(key), where + "/" + key);
    }
  } else {
    EXPECT_EQ(a, b) << where;
  }
}

class HardwareScan : public testing::Test {
 protected:
  void SetUp() override {
    if (kRigCannotRun) GTEST_SKIP() << "the address sanitizer cannot run below umockdev's preloaded library";
  }
};

TEST_F(HardwareScan, SeesThroughTheWiresWhatTheTwinsSee) {
  constexpr int kViews = 5;
  HardwareRig wires({.patient = true});
  wires.Start();
  const Json status = wires.Call("station.status");
  EXPECT_EQ(status["station"], "hardware");
  for (const Json& device : status["devices"]) EXPECT_EQ(device["state"], "idle") << device << wires.Log();
  const Taken real = ScanOn(wires, kViews);
  HardwareRig twins({.hardware = false});
  twins.Start();
  const Taken twin = ScanOn(twins, kViews);
  ASSERT_EQ(real.exposures.size(), static_cast<std::size_t>(kViews)) << wires.Log();
  ASSERT_EQ(twin.exposures.size(), static_cast<std::size_t>(kViews));
  for (int view = 0; view < kViews; ++view) {
    const Exposure& a = real.exposures[view];
    const Exposure& b = twin.exposures[view];
    ASSERT_EQ(a.image.columns, b.image.columns);
    ASSERT_EQ(a.image.rows, b.image.rows);
    int finite = 0, different = 0;
    for (std::size_t i = 0; i < a.image.depth.size(); ++i) {
      const float x = a.image.depth[i], y = b.image.depth[i];
      finite += std::isfinite(y);
      different += std::isnan(x) != std::isnan(y) || (!std::isnan(x) && std::memcmp(&x, &y, sizeof x) != 0);
    }
    EXPECT_GT(finite, 1000) << view;
    EXPECT_EQ(different, 0) << view;
    EXPECT_NEAR(std::remainder(a.table_angle - b.table_angle, 2.0 * M_PI), 0.0, 1e-12);
  }
  EXPECT_GE(real.description["n_parts"], 1);
  ExpectSameNumbers(real.description, twin.description, "");
  EXPECT_FALSE(wires.bench().laser_shines());
  EXPECT_EQ(wires.Stop(), 0);
}

TEST_F(HardwareScan, TriggersByWireAsWell) {
  HardwareRig rig({.patient = true, .settings = {"station.trigger=wire"}});
  rig.Start();
  rig.Call("scan.start", {{"views", 2}});
  EXPECT_EQ(rig.WaitForScanEnd()["state"], "done") << rig.Log();
}

TEST_F(HardwareScan, ADeviceThatIsNotThereIsNamedWithItsRemedyAndComesBackByReset) {
  HardwareRig rig({.drive_baud = 9600, .settings = {"turntable.response_ms=200"}});
  rig.bench().SetFault(sim::Device::kRangefinder, sim::Fault::kOff);
  rig.Start();
  const Json devices = rig.Call("station.status")["devices"];
  EXPECT_EQ(devices[0]["state"], "absent");
  EXPECT_THAT(devices[0]["fault"].get<std::string>(), HasSubstr("Plug it in"));
  EXPECT_THAT(devices[1]["fault"].get<std::string>(), HasSubstr("it answers at 9600 baud with no parity")) << devices;
  EXPECT_THAT(devices[1]["fault"].get<std::string>(), HasSubstr("turntable.baud"));
  EXPECT_EQ(devices[2]["state"], "idle") << devices;
  rig.bench().SetFault(sim::Device::kRangefinder, sim::Fault::kNone);
  EXPECT_THROW(rig.Call("station.reset"), daemon::RpcError);  // the drive still says nothing
  EXPECT_EQ(rig.Call("station.status")["devices"][0]["state"], "idle") << rig.Log();
}

}  // namespace
}  // namespace geond
