// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "core/geometry/triangle_mesh.h"

namespace geond {

struct RemeshOptions {
  int triangles = 0;            // wanted number (about); used if edge_length is 0
  double edge_length = 0.0;     // m; 0: from `triangles`
  double crease_angle = 0.7;    // rad: edges whose normals turn by more are kept as creases
  int iterations = 8;
};

// Isotropic remeshing of a closed manifold mesh: split, collapse (with link check), flip, relax, project on the input.
// The result is closed, manifold, of the same genus; triangle_seen is carried over. Throws std::invalid_argument if the
// input is not closed and manifold.
TriangleMesh Remesh(const TriangleMesh& mesh, const RemeshOptions& options, std::stop_token stop = {});

}  // namespace geond
