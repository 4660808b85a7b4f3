// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/point_cloud.h"

namespace geond {

// Turns the normals of a cloud that goes round its object outward: neighbours alike, along the tree of neighbours that are
// most nearly parallel (Hoppe et al. 1992), then each piece so that its outermost points face away. Needs normals.
PointCloud OrientOutward(PointCloud cloud, int threads = 0);

// Whether neighbouring normals mostly agree in sign, so that they are worth keeping.
bool NormalsAgree(const PointCloud& cloud, int threads = 0);

}  // namespace geond
