// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/charge/lanes.h"
#include "core/charge/triangle_frame.h"

// The potential of a uniformly charged triangle, once, for a plain double and for a pack of them.
//
//   integral over T of dS'/|r - r'|  =  sum over the edges of P_i ln((R_i+ + l_i+)/(R_i- + l_i-))  -  |d| Omega
//
// (Wilton et al., IEEE Trans. Antennas Propag. 32 (1984) 276; thesis (A.1)). d is the height of r over the plane, P_i
// the distance of its foot to the line of edge i (positive inside), l_i-+ the positions of the edge's ends along that
// line seen from the foot, R_i-+ the distances of r to those ends. The thesis' arc tangents add up to the solid angle
// Omega, here in one arc tangent (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125) whose numerator is
// 2 S |d| and so never cancels. The logarithm's argument is written as a ratio of sums of positive terms in each of its
// three cases (foot before, beside or beyond the edge); that, too, cancels nowhere. On an edge or a vertex P_i and d
// vanish and so do their terms.
namespace geond::charge {
namespace {

// In single precision the triangle and the points must be seen from somewhere near both.
template <typename V, typename Real>
inline V TrianglePotentialFormula(const TriangleFrameOf<Real>& t, V x, V y, V z) {
  constexpr Real kTiny =
      sizeof(Real) == sizeof(float) ? 1e-30 : 1e-280;  // keeps 0/0 from arising where its factor is zero
  V to_vertex[3][3], distance[3];
  for (int i = 0; i < 3; ++i) {
    to_vertex[i][0] = t.vertex[i][0] - x;
    to_vertex[i][1] = t.vertex[i][1] - y;
    to_vertex[i][2] = t.vertex[i][2] - z;
    distance[i] =
        Sqrt(to_vertex[i][0] * to_vertex[i][0] + to_vertex[i][1] * to_vertex[i][1] + to_vertex[i][2] * to_vertex[i][2]);
  }
  const auto dot = [](const V* a, const V* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  const auto along = [](const V* a, const Real* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };

  const V height = Abs(along(to_vertex[0], t.normal));
  V sum = height * Real(0);
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    const V P = along(to_vertex[i], t.outward[i]);
    const V l_minus = along(to_vertex[i], t.edge[i]);
    const V l_plus = l_minus + t.length[i];
    const V s_minus = distance[i] + Abs(l_minus);
    const V s_plus = distance[next] + Abs(l_plus);
    const V R0_squared = P * P + height * height;
    const auto beyond = l_minus >= Real(0);  // the whole edge lies ahead of the foot
    const auto before = l_plus <= Real(0);
    const V numerator = Select(beyond, s_plus, Select(before, s_minus, s_minus * s_plus));
    const V denominator = Select(beyond, s_minus, Select(before, s_plus, R0_squared));
    sum = sum + P * Log((numerator + kTiny) / (denominator + kTiny));
  }

  const V& Ra = distance[0];
  const V& Rb = distance[1];
  const V& Rc = distance[2];
  const V opening = Ra * Rb * Rc + dot(to_vertex[0], to_vertex[1]) * Rc + dot(to_vertex[0], to_vertex[2]) * Rb +
                    dot(to_vertex[1], to_vertex[2]) * Ra;
  const V omega = Real(2) * AtanOfRatio(t.twice_area * height + kTiny, opening);
  return sum - height * omega;
}

}  // namespace
}  // namespace geond::charge
