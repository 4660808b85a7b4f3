// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/pose.h"

namespace geond {

// Triangles on shared vertices (m), counter-clockwise seen from outside.
struct TriangleMesh {
  using Triangle = std::array<int, 3>;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Triangle> triangles;
  // One a triangle: 1 where a scanner saw the surface, 0 where it was closed over. Empty: nothing is known.
  std::vector<std::uint8_t> triangle_seen;

  bool empty() const { return triangles.empty(); }
};

// What holds of a mesh as a surface.
struct MeshTopology {
  bool closed = false;     // every edge has two triangles or more, and there is a triangle
  bool manifold = false;   // every edge has at most two triangles, met in opposite directions; every vertex one fan
  int components = 0;      // connected over shared edges
  int boundary_edges = 0;  // edges of one triangle
  int genus = 0;           // sum over the components; meaningful only if closed and manifold
};

Eigen::Vector3d TriangleCentroid(const TriangleMesh& mesh, int triangle);
// Half the cross product of two sides: along the outward normal, as long as the area is large.
Eigen::Vector3d TriangleAreaVector(const TriangleMesh& mesh, int triangle);
std::vector<Eigen::Vector3d> TriangleNormals(const TriangleMesh& mesh);  // unit; zero for a triangle without area
std::vector<double> TriangleAreas(const TriangleMesh& mesh);            // m^2
std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh);    // unit, weighted by angle

// Area (m^2) and signed volume (m^3; positive if closed and oriented outward).
double Area(const TriangleMesh& mesh);
double Volume(const TriangleMesh& mesh);
// The smallest angle of any triangle, rad.
double MinAngle(const TriangleMesh& mesh);
double MeanEdgeLength(const TriangleMesh& mesh);

// The direct connection graph (thesis Def. 4.2): for each triangle the triangle over each edge (v0v1, v1v2, v2v0), or -1
// at a border. Over an edge of more than two triangles the next one in order of index. Linear in triangles.
std::vector<std::array<int, 3>> TriangleNeighbors(const TriangleMesh& mesh);

MeshTopology Topology(const TriangleMesh& mesh);

// Throws std::invalid_argument, naming the triangle, if an index is out of range or a vertex used is not finite.
void CheckMesh(const TriangleMesh& mesh);

TriangleMesh Transform(const Pose& X_AB, const TriangleMesh& mesh_B);

}  // namespace geond
