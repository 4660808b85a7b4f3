// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/parts/segment.h"

namespace geond {

// The data of a part without those of its hollow, such as the inner wall of a cup: of triangles from whose middle the
// way straight out meets the part again. Empty if the part has no hollow to speak of, little else,
// or more than 6,000 triangles. The mesh is closed.
PointCloud OutsideOfPart(const PointCloud& cloud, const TriangleMesh& mesh, const PartSegmentation& segmentation,
                         int part);

}  // namespace geond
