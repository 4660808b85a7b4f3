// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond {

// What is known about a part besides its points, in the frame of the points (m). All may be empty: then nothing is
// known.
struct Surroundings {
  std::vector<Eigen::Vector3d> empty;  // places without surface or inside: a scanner looked through them
  std::vector<Eigen::Vector3d> cuts;   // places where the part was cut from its neighbours: what lies behind is hidden
};

}  // namespace geond
