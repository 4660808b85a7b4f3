// SPDX-License-Identifier: Apache-2.0
#include "core/charge/panels.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

namespace geond::charge {
namespace {

// Two triangles that share their centroid are found among neighbours in the order of one odd direction, in which hardly
// any mesh is flat.
void CheckCentroidsDiffer(const Panels& panels) {
  constexpr double kRelativeDistance = 1e-9;
  std::vector<std::pair<double, int>> order(panels.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = {0.38196601 * panels.x[i] + 0.57079633 * panels.y[i] + 0.72654253 * panels.z[i], static_cast<int>(i)};
  }
  std::sort(order.begin(), order.end());
  for (std::size_t a = 0; a < order.size(); ++a) {
    const int i = order[a].second;
    const double near = kRelativeDistance * panels.diameter[i];
    for (std::size_t b = a + 1; b < order.size() && order[b].first - order[a].first <= near; ++b) {
      const int j = order[b].second;
      if (std::hypot(panels.x[i] - panels.x[j], panels.y[i] - panels.y[j], panels.z[i] - panels.z[j]) <= near) {
        throw std::invalid_argument("triangles " + std::to_string(std::min(i, j)) + " and " +
                                    std::to_string(std::max(i, j)) +
                                    " have the same centroid, so their charges cannot be told apart: remove one of them");
      }
    }
  }
}

}  // namespace

TriangleFrame MakeTriangleFrame(const Eigen::Vector3d& v1, const Eigen::Vector3d& v2, const Eigen::Vector3d& v3) {
  TriangleFrame frame;
  const Eigen::Vector3d* const vertices[3] = {&v1, &v2, &v3};
  // The two sides that meet at the widest angle give the most accurate normal.
  int apex = 0;
  double longest = -1.0;
  for (int i = 0; i < 3; ++i) {
    const double opposite = (*vertices[(i + 2) % 3] - *vertices[(i + 1) % 3]).squaredNorm();
    if (opposite > longest) longest = opposite, apex = i;
  }
  const Eigen::Vector3d& a = *vertices[apex];
  const Eigen::Vector3d cross = (*vertices[(apex + 1) % 3] - a).cross(*vertices[(apex + 2) % 3] - a);
  frame.twice_area = cross.norm();
  const Eigen::Vector3d normal = cross / frame.twice_area;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d side = *vertices[(i + 1) % 3] - *vertices[i];
    frame.length[i] = side.norm();
    const Eigen::Vector3d edge = side / frame.length[i], outward = edge.cross(normal);
    for (int k = 0; k < 3; ++k) {
      frame.vertex[i][k] = (*vertices[i])[k];
      frame.edge[i][k] = edge[k];
      frame.outward[i][k] = outward[k];
    }
    frame.normal[i] = normal[i];
  }
  return frame;
}

Panels MakePanels(const TriangleMesh& mesh) {
  constexpr double kFlat = 1e-12;  // twice the area over the longest side squared
  if (mesh.empty()) throw std::invalid_argument("the mesh has no triangles, so there is nothing to charge");
  CheckMesh(mesh);
  Panels panels;
  const std::size_t n = mesh.triangles.size();
  for (auto* values : {&panels.x, &panels.y, &panels.z, &panels.area, &panels.diameter}) values->resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [ia, ib, ic] = mesh.triangles[i];
    const Eigen::Vector3d &a = mesh.vertices[ia], &b = mesh.vertices[ib], &c = mesh.vertices[ic];
    const Eigen::Vector3d centroid = (a + b + c) / 3.0;
    panels.x[i] = centroid.x(), panels.y[i] = centroid.y(), panels.z[i] = centroid.z();
    panels.diameter[i] = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double twice_area = (b - a).cross(c - a).norm();
    panels.area[i] = 0.5 * twice_area;
    if (!(twice_area > kFlat * panels.diameter[i] * panels.diameter[i])) {
      throw std::invalid_argument("triangle " + std::to_string(i) +
                                  " has no area, so it can hold no charge: remove it or remesh the surface");
    }
  }
  CheckCentroidsDiffer(panels);
  return panels;
}

TriangleFrame FrameOf(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return MakeTriangleFrame(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
}

}  // namespace geond::charge
