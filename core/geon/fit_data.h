// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "core/geon/misfit.h"
#include "core/geon/surroundings.h"
#include "core/geometry/point_cloud.h"

namespace geond {

// A part as the optimisers take it: cleaned, in a frame and a unit of its own, so that where it lies, how it is turned, how
// large it is and in what order its points come make no difference.
struct FitData {
  LanePoints all;          // up to max_points of them, along a space-filling curve; behind them empty places near them
  LanePoints few;          // every so manieth of both, for the search
  Surroundings around;     // in the own frame and unit: the empty places of `all`, and the cuts
  Pose X_TN;               // the own frame in that of the data: at the mean, axes along the principal ones
  double unit = 1.0;       // m, one of the own unit: the diagonal of the points' box in the own frame
  Eigen::AlignedBox3d box; // of the points, in the own frame and unit
  Eigen::Vector3d view = Eigen::Vector3d::Zero();   // to the sensor if all points were seen from one side, else zero
  int used = 0;            // points left after cleaning
  int dropped = 0;         // not finite, without a normal, or there twice
  int outliers = 0;        // of the max_points: on no surface with their neighbours, left out
};

// Throws std::invalid_argument if `part` has no normals, fewer than 12 usable points, or all of them in one place.
// Without surroundings and with `outline`, places outside the outline of points seen from one side are taken for empty.
FitData PrepareFitData(const PointCloud& part, const Surroundings& around, bool outline, int max_points,
                       int search_points);
// The points and nothing else.
FitData PrepareFitData(const PointCloud& part, int max_points, int search_points);

}  // namespace geond
