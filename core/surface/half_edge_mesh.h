// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace geond {

// A closed two-manifold that changes under local operations, each of which keeps it closed, manifold and of its genus.
// Half-edge h is side h % 3 of triangle h / 3 and runs from origin[h] to origin[Next(h)]; dead ones have origin -1.
struct HalfEdgeMesh {
  std::vector<Eigen::Vector3d> points;
  std::vector<int> outgoing;          // one a vertex: a half-edge that starts there; -1: dead
  std::vector<int> origin;            // one a half-edge
  std::vector<int> twin;              // one a half-edge: the same edge the other way
  std::vector<std::uint8_t> crease;   // one a half-edge, equal on twins: the surface is bent here on purpose

  // Throws std::invalid_argument if the mesh is not closed and manifold.
  explicit HalfEdgeMesh(const TriangleMesh& mesh);

  static int Next(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static int Prev(int h) { return h % 3 == 0 ? h + 2 : h - 1; }
  int n_half_edges() const { return static_cast<int>(origin.size()); }
  int n_vertices() const { return static_cast<int>(points.size()); }
  bool alive(int h) const { return origin[h] >= 0; }
  int target(int h) const { return origin[Next(h)]; }
  int opposite(int h) const { return origin[Prev(h)]; }
  double SquaredLength(int h) const { return (points[target(h)] - points[origin[h]]).squaredNorm(); }
  // The half-edge after h among those that start where h does, clockwise seen from outside.
  int Around(int h) const { return twin[Prev(h)]; }
  // Calls visit(h) for each half-edge that starts at v.
  template <typename Visit>
  void ForEachOutgoing(int v, const Visit& visit) const {
    const int first = outgoing[v];
    int h = first;
    do {
      visit(h);
      h = Around(h);
    } while (h != first);
  }
  int Valence(int v) const;
  bool Adjacent(int u, int v) const;
  // Twice the area vector of the triangle of h.
  Eigen::Vector3d Cross(int h) const;

  // Puts a vertex at p on the edge of h; returns it.
  int Split(int h, const Eigen::Vector3d& p);
  // Whether the edge can be turned in the two triangles at it without doubling another edge.
  bool CanFlip(int h) const;
  void Flip(int h);
  // The link condition: the ends of h have exactly two neighbours in common, and more than a tetrahedron is left.
  bool CanCollapse(int h) const;
  // Moves origin(h) into target(h) and takes the two triangles at h away.
  void Collapse(int h);

  // The living triangles on the living vertices.
  TriangleMesh ToMesh() const;
};

}  // namespace geond
