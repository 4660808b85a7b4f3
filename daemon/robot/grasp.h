// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/geon/geon.h"

namespace geond::daemon {

// A parallel gripper. Its frame H: origin between the tips of the fingers, z the way it comes from behind (approach), x the
// way it closes.
struct Gripper {
  double max_opening = 0.085;       // m, between the fingers
  double finger_length = 0.045;     // m, from palm to tip
  double finger_width = 0.020;      // m, along y of H
  double finger_thickness = 0.010;  // m, along x of H
  double palm_width = 0.100;        // m, along x of H, and half as deep along y
  double reach = 0.012;             // m that the tips go beyond the middle of what they hold
  double clearance = 0.004;         // m to keep on each side when it is open, and to everything else
};

// One way to take a part.
struct Grasp {
  int part = 0;            // index into the parts given
  Pose X_TH;               // of the gripper when it closes
  double opening = 0.0;    // m, of the part between the fingers
  double clearance = 0.0;  // m, from fingers and palm to the nearest other part or the table
  double quality = 0.0;    // 0 to 1: parallel faces, near the middle, room around, from above
  std::string reason;      // in words
};

// The ways to take a part of an object on a table (z = 0 in T), best first; none if nothing is free. The shapes are in T.
// Surfaces are taken as samples of about 2 mm, so clearances are to about that. Deterministic.
std::vector<Grasp> FindGrasps(const std::vector<Geon>& parts, int part, const Gripper& gripper = {});

}  // namespace geond::daemon
