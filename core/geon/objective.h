// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geon/geon.h"
#include "core/geometry/point_cloud.h"

namespace geond {

// How well a geon describes points with normals (thesis 5.3).
struct Objective {
  double t1 = 0.0;         // mean |e|, m (5.19)
  double t2 = 0.0;         // mean |n_d - n_m|^2 (5.24)
  double value = 0.0;      // E = t1 + lambda gamma t2, gamma the mean half size, m (5.18)
  double distance = 0.0;   // mean first-order orthogonal distance, m
};

// The same for one point.
struct PointError {
  double e = 0.0;                // (5.20), m: along the ray through the centre, undeformed; negative inside
  Eigen::Vector3d model_normal = Eigen::Vector3d::Zero();  // n_m, in the frame of the data
  double distance = 0.0;         // first-order orthogonal distance (X - x_s) . n_m, m; negative inside
};

// `part` needs normals. Throws std::invalid_argument if it has none, or if the geon is none (CheckGeon).
std::vector<PointError> PointErrors(const Geon& geon, const PointCloud& part);
Objective EvaluateObjective(const Geon& geon, const PointCloud& part, double lambda);

}  // namespace geond
