// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace geond::charge {

// A triangle as the potential's closed form wants it, in plain numbers: edge i runs from vertex i to the next.
template <typename Real>
struct TriangleFrameOf {
  Real vertex[3][3];
  Real edge[3][3];     // unit, along the edge
  Real outward[3][3];  // unit, in the plane, away from the triangle
  Real length[3];      // of the edge
  Real normal[3];      // unit
  Real twice_area;
};
using TriangleFrame = TriangleFrameOf<double>;

}  // namespace geond::charge
