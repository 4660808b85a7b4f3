// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/point_cloud.h"

namespace geond {

// Unit normals by a plane fitted to the `neighbors` nearest points of each; their signs are arbitrary. Throws
// std::invalid_argument for fewer points than neighbors.
PointCloud EstimateCloudNormals(PointCloud cloud, int neighbors = 20, int threads = 0);

// Turns the normals of a surface seen from one side towards the sensor: at `viewpoint`. Throws std::invalid_argument
// without normals.
PointCloud OrientTowards(PointCloud cloud, const Eigen::Vector3d& viewpoint);

// The direction (unit, in the cloud's frame) from which a cloud of one side was most likely taken: the one that makes
// neighbouring normals agree best when they are turned towards it, and the surface bulge. Needs normals of any sign.
Eigen::Vector3d GuessViewingSide(const PointCloud& cloud);

// The cloud as it is if it has normals; else with estimated ones that point out of the body. Of a cloud that goes round its
// middle: away from there. Of one side of a body: towards the sensor, at the origin if that lies well away from the points,
// else on the side that makes a body of it. `notes` (or null) is told what was assumed.
PointCloud WithOutwardNormals(const PointCloud& cloud, std::vector<std::string>* notes = nullptr);

}  // namespace geond
