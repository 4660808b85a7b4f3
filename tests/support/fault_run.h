// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "tests/support/hardware_rig.h"

namespace geond {

// What came of something going wrong; times in ms from then, infinite: never.
struct FaultOutcome {
  std::string error;  // the scan's; empty: it was done
  double to_error = 0.0, to_dark = 0.0, to_standing = 0.0;
  bool next_scan = false;  // after mending and a reset, a scan was done
};

// When, after `begin`, the laser went off and the table stood for good (0: they were by then).
void MeasureOff(sim::FakeBench& bench, std::chrono::steady_clock::time_point begin, FaultOutcome& outcome);

// Starts a scan and returns in its second motion, with the laser on.
void StartInMotion(HardwareRig& rig);

// Lets something go wrong in mid-motion of a scan, mends it, resets the station and scans again.
FaultOutcome RunFault(HardwareRig& rig, const std::function<void()>& inject, const std::function<void()>& mend);

}  // namespace geond
