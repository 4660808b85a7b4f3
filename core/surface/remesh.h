// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>

#include "core/geometry/triangle_mesh.h"

namespace geond {

struct RemeshOptions {
  int triangles = 0;            // wanted number (about); used if edge_length is 0
  double edge_length = 0.0;     // m; 0: from `triangles`
  double crease_angle = 0.7;    // rad: edges whose normals turn by more are kept as creases; > pi: none
  int iterations = 8;
  int threads = 0;
};

// Isotropic remeshing of a closed manifold mesh: split, collapse (with link check), flip, relax, project on the input.
// The result is closed, manifold, of the same genus; triangle_seen is carried over. Throws std::invalid_argument if the
// input is not closed and manifold, or if neither an edge length nor a number of triangles is given.
TriangleMesh Remesh(const TriangleMesh& mesh, const RemeshOptions& options, std::stop_token stop = {});

// The point of a surface that belongs to p, given the unit normal of the mesh there. Called from several threads at once.
using SurfaceProjection = std::function<Eigen::Vector3d(const Eigen::Vector3d& p, const Eigen::Vector3d& normal)>;

// The same onto a surface given by its projection instead of the mesh's own triangles; triangle_seen is left empty.
TriangleMesh RemeshOnto(const TriangleMesh& mesh, const SurfaceProjection& project, const RemeshOptions& options,
                        std::stop_token stop = {});

// Turns edges for larger angles and relaxes along the surface some more, with the number of triangles as it is.
TriangleMesh RelaxOnto(const TriangleMesh& mesh, const SurfaceProjection& project, int rounds, int threads,
                       std::stop_token stop = {});

}  // namespace geond
