// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "core/surface/half_edge_mesh.h"
#include "core/surface/remesh.h"

namespace geond {

// The local operations of isotropic remeshing, on one mesh. Creases are the edges marked in `mesh`; a vertex on two of
// them slides along, one marked `fixed` stays.
class Remesher {
 public:
  Remesher(HalfEdgeMesh mesh, double edge_length, int threads);

  void MarkCreases(double angle);
  void SetEdgeLength(double edge_length) { edge_length_ = edge_length; }
  double edge_length() const { return edge_length_; }
  const HalfEdgeMesh& mesh() const { return mesh_; }
  int CountTriangles() const;

  void SplitLongEdges();
  // `merge_creases`: edges under 0.4 of the wanted length go even where that joins two creases.
  void CollapseShortEdges(bool merge_creases);
  // Takes out triangles with an angle of less than `angle` (rad) by collapsing their shortest side, whatever its length.
  void CollapseSlivers(double angle);
  void FlipToValence();
  // Flips that make the smallest angle of the two triangles larger.
  void FlipToAngle();
  // Moves every vertex that may to the centre of its surroundings, along the surface, and on to the surface.
  // `on_crease` may be empty if no edge is marked.
  void Relax(const SurfaceProjection& on_surface, const SurfaceProjection& on_crease);

 private:
  int CreaseEdges(int v) const;
  bool TurnsOver(int v, const Eigen::Vector3d& to, int ignore_h) const;
  bool FlipKeepsShape(int h) const;
  double SmallestAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) const;
  bool TryCollapse(int h, bool merge_creases, double longest);

  HalfEdgeMesh mesh_;
  std::vector<std::uint8_t> fixed_;
  double edge_length_;
  int threads_;
};

}  // namespace geond
