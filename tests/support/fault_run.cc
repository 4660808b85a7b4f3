// SPDX-License-Identifier: Apache-2.0
#include "tests/support/fault_run.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <thread>

#include "daemon/rpc.h"

namespace geond {
namespace {

using daemon::Json;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr double kNever = std::numeric_limits<double>::infinity();

double Ms(Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); }

bool ResetAndScan(HardwareRig& rig) {
  for (int attempt = 0; attempt < 5; ++attempt) {  // what was mended may need a moment to be there
    try {
      rig.Call("station.reset");
      break;
    } catch (const daemon::RpcError&) {
      std::this_thread::sleep_for(milliseconds(50));
    }
  }
  try {
    rig.Call("scan.start", {{"views", 2}});
    const Json end = rig.WaitForScanEnd();
    if (end["state"] != "done") std::cerr << "  next scan: " << end << "\n";
    return end["state"] == "done";
  } catch (const daemon::RpcError& error) {
    std::cerr << "  next scan: " << error.what() << "\n";
    return false;
  }
}

}  // namespace

void MeasureOff(sim::FakeBench& bench, Clock::time_point begin, FaultOutcome& outcome) {
  const Clock::time_point give_up = Clock::now() + milliseconds(5000);
  while ((bench.laser_shines() || bench.table_turns()) && Clock::now() < give_up)
    std::this_thread::sleep_for(milliseconds(1));
  outcome.to_dark = bench.laser_shines() ? kNever : 0.0;
  outcome.to_standing = bench.table_turns() ? kNever : 0.0;
  for (const sim::BenchEvent& event : bench.TakeEvents()) {
    const double time = Ms(event.time - begin);
    if (time < 0.0) continue;
    if (event.kind == sim::BenchEvent::Kind::kLaserOff) outcome.to_dark = std::max(outcome.to_dark, time);
    if (event.kind == sim::BenchEvent::Kind::kMotionEnds) outcome.to_standing = std::max(outcome.to_standing, time);
  }
}

void StartInMotion(HardwareRig& rig) {
  rig.Call("scan.start", {{"views", 4}});
  while (rig.WaitForEvent("view")["view"] != 0) {
  }
  while (!rig.bench().table_turns()) std::this_thread::sleep_for(milliseconds(1));
  rig.bench().TakeEvents();
}

FaultOutcome RunFault(HardwareRig& rig, const std::function<void()>& inject, const std::function<void()>& mend) {
  StartInMotion(rig);
  const Clock::time_point begin = Clock::now();
  inject();
  const Json end = rig.WaitForScanEnd();
  FaultOutcome outcome;
  outcome.to_error = Ms(Clock::now() - begin);
  if (end["state"] != "done") outcome.error = end["error"]["message"].get<std::string>();
  MeasureOff(rig.bench(), begin, outcome);
  mend();
  outcome.next_scan = ResetAndScan(rig);
  return outcome;
}

}  // namespace geond
