// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geon/misfit.h"

namespace geond {

// Frames in which an object of one of the seven shapes stands straight: the principal axes of the points, of the scatter of
// the normals, and the axes of the normals' quartic form (where sum (n.u)^4 is stationary: the faces of a box). Frames that
// say the same up to order and signs of axes are listed once.
std::vector<Eigen::Matrix3d> CandidateFrames(const LanePoints& points);

// Adds a frame unless one that says the same is there.
void AddFrame(const Eigen::Matrix3d& axes, std::vector<Eigen::Matrix3d>& frames);

// Geons to start the search from: every frame, every choice and direction of the axis that makes a difference to the type,
// bends at half angles of 0.5 and 1.2 rad; sizes and centre from the points' extent. If they were all seen from one side
// (`view` to the sensor, else zero), again with as much behind as in front.
std::vector<GeonState> StartStates(GeonType type, const std::vector<Eigen::Matrix3d>& frames, const LanePoints& points,
                                   const Eigen::Vector3d& view);

// A fit of the base type, a little tapered or bent in every way that makes a difference.
std::vector<GeonState> StartsFromBase(GeonType type, const GeonState& base);

}  // namespace geond
