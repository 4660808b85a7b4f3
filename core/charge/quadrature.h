// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>

#include "core/geometry/triangle_mesh.h"

namespace geond::charge {

// A point of a rule for triangles: weights of the three corners, and its share of the area.
struct RulePoint { double a, b, c, share; };

// Exact for polynomials of degree 1, 2, and 5 (Radon 1948).
inline constexpr std::array<RulePoint, 1> kOnePoint = {{{1. / 3, 1. / 3, 1. / 3, 1.}}};
inline constexpr std::array<RulePoint, 3> kThreePoints = {{{2. / 3, 1. / 6, 1. / 6, 1. / 3},
                                                           {1. / 6, 2. / 3, 1. / 6, 1. / 3},
                                                           {1. / 6, 1. / 6, 2. / 3, 1. / 3}}};
inline constexpr double kRadonFar = 0.101286507323456338800987361915, kRadonFarShare = 0.125939180544827152595683945500;
inline constexpr double kRadonNear = 0.470142064105115089770441209513, kRadonNearShare = 0.132394152788506180737649387833;
inline constexpr std::array<RulePoint, 7> kSevenPoints = {
    {{1. / 3, 1. / 3, 1. / 3, 0.225},
     {1 - 2 * kRadonFar, kRadonFar, kRadonFar, kRadonFarShare},
     {kRadonFar, 1 - 2 * kRadonFar, kRadonFar, kRadonFarShare},
     {kRadonFar, kRadonFar, 1 - 2 * kRadonFar, kRadonFarShare},
     {1 - 2 * kRadonNear, kRadonNear, kRadonNear, kRadonNearShare},
     {kRadonNear, 1 - 2 * kRadonNear, kRadonNear, kRadonNearShare},
     {kRadonNear, kRadonNear, 1 - 2 * kRadonNear, kRadonNearShare}}};

inline Eigen::Vector3d PlaceOf(const RulePoint& point, const TriangleMesh& mesh, int triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return point.a * mesh.vertices[a] + point.b * mesh.vertices[b] + point.c * mesh.vertices[c];
}

}  // namespace geond::charge
