// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/point_cloud.h"

#include <stdexcept>

namespace geond {

PointCloud Transform(const Pose& X_AB, const PointCloud& cloud_B) {
  PointCloud cloud_A = cloud_B;
  for (Eigen::Vector3d& p : cloud_A.points) p = X_AB * p;
  for (Eigen::Vector3d& n : cloud_A.normals) n = X_AB.Rotate(n);
  return cloud_A;
}

PointCloud Select(const PointCloud& cloud, const std::vector<int>& indices) {
  PointCloud selected;
  const auto pick = [&](const auto& from, auto& to) {
    if (from.empty()) return;
    to.reserve(indices.size());
    for (int i : indices) to.push_back(from.at(i));
  };
  pick(cloud.points, selected.points);
  pick(cloud.normals, selected.normals);
  pick(cloud.normal_residuals, selected.normal_residuals);
  pick(cloud.views, selected.views);
  return selected;
}

Eigen::AlignedBox3d BoundingBox(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) throw std::invalid_argument("BoundingBox: no points");
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return box;
}

}  // namespace geond
