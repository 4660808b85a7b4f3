// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "core/geometry/triangle_mesh.h"

namespace geond::test {

// The surface of the unit cubes (i, j, k) of a solid, with 0 <= i, j, k < n, turned.
inline TriangleMesh MeshOfCubes(int n, const std::function<bool(int, int, int)>& solid,
                                const Eigen::Quaterniond& turned = Eigen::Quaterniond::Identity()) {
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
  return mesh;
}

}  // namespace geond::test
