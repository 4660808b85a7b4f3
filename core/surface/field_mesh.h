// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/surface/remesh.h"
#include "core/surface/signed_grid.h"
#include "core/surface/tessellate.h"

namespace geond {

// The size of voxels (m) that suits data of this pitch (m) in this box and the wanted triangles.
double VoxelSize(double pitch, const Eigen::AlignedBox3d& box, const TessellateOptions& options);

// Takes away what lies below the plane z = 0, on which the grid has a layer of nodes.
void CutByTable(SignedGrid& grid);

// The components that count: of those that enclose anything (turned outward), all with at least a hundredth of the
// largest one's volume, without what lies inside them as a hollow.
TriangleMesh LargeComponents(const TriangleMesh& mesh);

// On to the zero level of the grid by Newton's steps; the plane z = 0 stays sharp if it cuts the object.
SurfaceProjection FieldProjection(const SignedGrid& grid, bool closed_by_table);

// triangle_seen: 1 where one of `points` lies within `reach` (m) of the triangle's centroid.
void MarkSeen(TriangleMesh& mesh, const std::vector<Eigen::Vector3d>& points, double reach, int threads);

}  // namespace geond
