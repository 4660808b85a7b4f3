// SPDX-License-Identifier: Apache-2.0
#include "core/parts/hull_depth.h"

#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "core/parts/part_surface.h"
#include "tests/core/mesh_of_cubes.h"

namespace geond {
namespace {

const Eigen::Quaterniond kTurned = Eigen::Quaterniond(0.7, 0.2, -0.5, 0.3).normalized();

TEST(GreatestHullDepth, AFlatThinPlateIsConvexHoweverItIsTurned) {
  const auto plate = [](int, int, int k) { return k < 2; };
  for (const Eigen::Quaterniond& turned : {Eigen::Quaterniond::Identity(), kTurned}) {
    const PartSurface surface = MakePartSurface(test::MeshOfCubes(24, plate, turned), 0.0);
    EXPECT_LT(GreatestHullDepth(surface.graph, 1.5 * surface.graph.edge), 1e-9 * surface.graph.size);
  }
}

TEST(GreatestHullDepth, TheCornerOfAnLLiesBelowTheSlopeThatClosesIt) {
  const auto l_shape = [](int i, int j, int) { return i < 10 || j < 10; };
  const PartSurface surface = MakePartSurface(test::MeshOfCubes(20, l_shape, kTurned), 0.0);
  // From (10, 10) to the line through (10, 20) and (20, 10); the pieces next to it have their middles a cube off.
  EXPECT_NEAR(GreatestHullDepth(surface.graph, 1.5 * surface.graph.edge), 10.0 / std::sqrt(2.0), 0.7);
}

}  // namespace
}  // namespace geond
