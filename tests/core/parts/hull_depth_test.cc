// SPDX-License-Identifier: Apache-2.0
#include "core/parts/hull_depth.h"

#include <array>
#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "core/parts/part_surface.h"

namespace geond {
namespace {

// The surface of the unit cubes (i, j, k) of a solid, with 0 <= i, j, k < n, turned.
PartSurface SurfaceOfCubes(int n, const std::function<bool(int, int, int)>& solid, const Eigen::Quaterniond& turned) {
  const auto inside = [&](const std::array<int, 3>& c) {
    for (int value : c) {
      if (value < 0 || value >= n) return false;
    }
    return solid(c[0], c[1], c[2]);
  };
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> number;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = number.insert({at, static_cast<int>(mesh.vertices.size())});
    if (is_new) mesh.vertices.push_back(turned * Eigen::Vector3d(at[0], at[1], at[2]));
    return found->second;
  };
  for (int at = 0; at < n * n * n; ++at) {
    const std::array<int, 3> cube = {at % n, at / n % n, at / n / n};
    if (!inside(cube)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      for (int side : {0, 1}) {
        std::array<int, 3> beyond = cube;
        beyond[axis] += side ? 1 : -1;
        if (inside(beyond)) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<std::array<int, 3>, 4> corners;
        corners.fill(cube);
        for (auto& corner : corners) corner[axis] += side;
        ++corners[1][u], ++corners[2][u], ++corners[2][v], ++corners[3][v];
        if (!side) std::swap(corners[1], corners[3]);
        const int a = vertex(corners[0]), b = vertex(corners[1]), c = vertex(corners[2]), d = vertex(corners[3]);
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
    }
  }
  return MakePartSurface(mesh, 0.0);
}

const Eigen::Quaterniond kTurned = Eigen::Quaterniond(0.7, 0.2, -0.5, 0.3).normalized();

TEST(GreatestHullDepth, AFlatThinPlateIsConvexHoweverItIsTurned) {
  const auto plate = [](int, int, int k) { return k < 2; };
  for (const Eigen::Quaterniond& turned : {Eigen::Quaterniond::Identity(), kTurned}) {
    const PartSurface surface = SurfaceOfCubes(24, plate, turned);
    EXPECT_LT(GreatestHullDepth(surface.graph, 1.5 * surface.graph.edge), 1e-9 * surface.graph.size);
  }
}

TEST(GreatestHullDepth, TheCornerOfAnLLiesBelowTheSlopeThatClosesIt) {
  const auto l_shape = [](int i, int j, int) { return i < 10 || j < 10; };
  const PartSurface surface = SurfaceOfCubes(20, l_shape, kTurned);
  // From (10, 10) to the line through (10, 20) and (20, 10); the pieces next to it have their middles a cube off.
  EXPECT_NEAR(GreatestHullDepth(surface.graph, 1.5 * surface.graph.edge), 10.0 / std::sqrt(2.0), 0.7);
}

}  // namespace
}  // namespace geond
