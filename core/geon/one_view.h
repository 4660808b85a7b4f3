// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond {

// What points tell that were all seen from one side.
struct OneView {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // to the sensor: all normals face it; zero if there is none, as
                                                        // in data from all around
  std::vector<Eigen::Vector3d> empty;  // places outside the points' outline along it, at any depth: surface
                                       // there would have been seen. By one to some gaps between points
};
// The frame and scale do not matter.
OneView FindOneView(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals);

}  // namespace geond
