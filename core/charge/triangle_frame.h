// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace geond::charge {

// A triangle as the potential's closed form wants it, in plain doubles: edge i runs from vertex i to the next.
struct TriangleFrame {
  double vertex[3][3];
  double edge[3][3];     // unit, along the edge
  double outward[3][3];  // unit, in the plane, away from the triangle
  double length[3];      // of the edge
  double normal[3];      // unit
  double twice_area;
};

}  // namespace geond::charge
