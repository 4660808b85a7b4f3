// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/pose.h"

namespace geond {

// Points of a surface (m) and what is known of each. Every list but `points` is empty or of the same length.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> normals;   // unit, outward (or towards the sensor)
  std::vector<double> normal_residuals;   // rms of the plane fit that gave the normal, m
  std::vector<int> views;                 // index of the view each point came from

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  bool has_normals() const { return !points.empty() && normals.size() == points.size(); }
};

// The cloud in frame A of one in frame B.
PointCloud Transform(const Pose& X_AB, const PointCloud& cloud_B);

// The points at `indices`, in that order, with all that is known of them.
PointCloud Select(const PointCloud& cloud, const std::vector<int>& indices);

// Opposite corners of the axis-parallel box of the points. Throws std::invalid_argument if there are none.
Eigen::AlignedBox3d BoundingBox(const std::vector<Eigen::Vector3d>& points);

}  // namespace geond
