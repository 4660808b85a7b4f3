// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/range/range_view.h"

namespace geond {

struct TessellateOptions {
  int triangles = 3000;           // wanted number of triangles (about); used if edge_length is 0
  double edge_length = 0.0;       // m, wanted length of the edges; 0: from `triangles`
  double voxel_size = 0.0;        // m; 0: chosen from the pitch of the data and the wanted edges
  bool close_on_table = true;     // the plane z = 0 in T closes the unseen bottom
  int threads = 0;
};

// One closed two-manifold mesh in T of several registered views: truncated signed distance of the views with carving of
// free space, marching tetrahedra, isotropic remeshing. `merged` gives scale and bounds. Throws std::invalid_argument if
// there is nothing to mesh.
TriangleMesh Tessellate(std::span<const RangeView> views, const PointCloud& merged,
                        const TessellateOptions& options = {}, std::stop_token stop = {});

// The same from a bare cloud without views (a file from elsewhere): normals are estimated and oriented if absent.
// Throws std::invalid_argument in one clear sentence if the cloud cannot be closed sensibly.
TriangleMesh TessellateCloud(const PointCloud& cloud, const TessellateOptions& options = {},
                             std::stop_token stop = {});

struct ViewMeshOptions {
  double psi = 0.2;               // (C.2): depth of the bottom patch below the top patch's far end, of its extent in z
  double max_depth_jump = 0.0;    // m: edges longer than this in z are not spanned; 0: from the noise and the pitch
  int step = 1;                   // use every step-th pixel
};

// Closed mesh (in S) of one view: top, side and bottom patch (thesis App. C, Algorithm C.1, corrections 31). Triangles of
// the top patch come first and are `seen`.
TriangleMesh TessellateView(const RangeView& view, const ViewMeshOptions& options = {});

}  // namespace geond
