// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"

namespace geond {

// `count` points spread evenly over the triangles by area, each with its triangle's normal; the same for the same mesh.
// With `only_seen`, triangles known to be closed over get none. Throws std::invalid_argument if there is no area.
PointCloud SampleMesh(const TriangleMesh& mesh, int count, bool only_seen = false);

}  // namespace geond
