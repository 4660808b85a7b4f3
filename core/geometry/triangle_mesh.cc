// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>

namespace geond {
namespace {

// An edge of a triangle, its ends in order of index.
struct HalfEdge {
  int low, high;
  int triangle, side;
  bool forward;  // the triangle runs from low to high
};

std::vector<HalfEdge> SortedHalfEdges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int from = mesh.triangles[t][side], to = mesh.triangles[t][(side + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), side, from < to});
    }
  }
  // Two passes of a counting sort would be linear; in practice this is as fast.
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle, a.side) < std::tie(b.low, b.high, b.triangle, b.side);
  });
  return edges;
}

// Calls on_edge(first, last) for each run of half-edges on the same two vertices.
template <typename OnEdge>
void ForEachEdge(const std::vector<HalfEdge>& edges, const OnEdge& on_edge) {
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin + 1;
    while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high) ++end;
    on_edge(begin, end);
    begin = end;
  }
}

int FindRoot(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

Eigen::Vector3d TriangleCentroid(const TriangleMesh& mesh, int triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0;
}

Eigen::Vector3d TriangleAreaVector(const TriangleMesh& mesh, int triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return 0.5 * (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
}

std::vector<Eigen::Vector3d> TriangleNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.triangles.size());
  for (std::size_t t = 0; t < normals.size(); ++t) normals[t] = TriangleAreaVector(mesh, static_cast<int>(t)).stableNormalized();
  return normals;
}

std::vector<double> TriangleAreas(const TriangleMesh& mesh) {
  std::vector<double> areas(mesh.triangles.size());
  for (std::size_t t = 0; t < areas.size(); ++t) areas[t] = TriangleAreaVector(mesh, static_cast<int>(t)).norm();
  return areas;
}

std::vector<Eigen::Vector3d> VertexNormals(const TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> normals(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d normal = TriangleAreaVector(mesh, static_cast<int>(t)).stableNormalized();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& at = mesh.vertices[mesh.triangles[t][k]];
      const Eigen::Vector3d u = mesh.vertices[mesh.triangles[t][(k + 1) % 3]] - at;
      const Eigen::Vector3d v = mesh.vertices[mesh.triangles[t][(k + 2) % 3]] - at;
      normals[mesh.triangles[t][k]] += std::atan2(u.cross(v).norm(), u.dot(v)) * normal;
    }
  }
  for (Eigen::Vector3d& n : normals) n = n.stableNormalized();
  return normals;
}

double Area(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += TriangleAreaVector(mesh, static_cast<int>(t)).norm();
  return area;
}

double Volume(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0.0;
  const Eigen::Vector3d origin = mesh.vertices[mesh.triangles[0][0]];  // near the surface: less cancellation
  double volume = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    volume += (mesh.vertices[a] - origin).dot((mesh.vertices[b] - origin).cross(mesh.vertices[c] - origin)) / 6.0;
  }
  return volume;
}

double MinAngle(const TriangleMesh& mesh) {
  double smallest = mesh.triangles.empty() ? 0.0 : std::numeric_limits<double>::infinity();
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d u = mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]];
      const Eigen::Vector3d v = mesh.vertices[triangle[(k + 2) % 3]] - mesh.vertices[triangle[k]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
  }
  return smallest;
}

double MeanEdgeLength(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0.0;
  double sum = 0.0;
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) sum += (mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]]).norm();
  }
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

std::vector<std::array<int, 3>> TriangleNeighbors(const TriangleMesh& mesh) {
  std::vector<std::array<int, 3>> neighbors(mesh.triangles.size(), {-1, -1, -1});
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  ForEachEdge(edges, [&](std::size_t begin, std::size_t end) {
    if (end - begin < 2) return;
    for (std::size_t i = begin; i < end; ++i) {
      neighbors[edges[i].triangle][edges[i].side] = edges[i + 1 < end ? i + 1 : begin].triangle;
    }
  });
  return neighbors;
}

MeshTopology Topology(const TriangleMesh& mesh) {
  MeshTopology topology;
  const int n = static_cast<int>(mesh.triangles.size());
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  std::vector<int> component(n);
  std::iota(component.begin(), component.end(), 0);
  // Corners (3 t + k) of one vertex that hang together over edges form a fan; a manifold vertex has one.
  std::vector<int> fan(3 * static_cast<std::size_t>(n));
  std::iota(fan.begin(), fan.end(), 0);
  const auto corner = [&](int triangle, int vertex) {
    const TriangleMesh::Triangle& t = mesh.triangles[triangle];
    return 3 * triangle + (t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2);
  };

  topology.manifold = n > 0;
  int n_edges = 0;
  ForEachEdge(edges, [&](std::size_t begin, std::size_t end) {
    ++n_edges;
    const HalfEdge& first = edges[begin];
    if (end - begin == 1) ++topology.boundary_edges;
    if (end - begin > 2 || first.low == first.high) topology.manifold = false;
    if (end - begin == 2 && first.forward == edges[begin + 1].forward) topology.manifold = false;
    for (std::size_t i = begin + 1; i < end; ++i) {
      component[FindRoot(component, edges[i].triangle)] = FindRoot(component, first.triangle);
      for (int vertex : {first.low, first.high}) {
        fan[FindRoot(fan, corner(edges[i].triangle, vertex))] = FindRoot(fan, corner(first.triangle, vertex));
      }
    }
  });

  int n_vertices = 0;
  std::vector<int> fans_at(mesh.vertices.size(), 0);
  for (int c = 0; c < 3 * n; ++c) {
    if (FindRoot(fan, c) != c) continue;
    int& fans = fans_at[mesh.triangles[c / 3][c % 3]];
    if (fans++ == 0) ++n_vertices;
    if (fans > 1) topology.manifold = false;
  }
  for (int t = 0; t < n; ++t) topology.components += FindRoot(component, t) == t;
  topology.closed = n > 0 && topology.boundary_edges == 0;
  topology.genus = (2 * topology.components - (n_vertices - n_edges + n)) / 2;
  return topology;
}

void CheckMesh(const TriangleMesh& mesh) {
  const int n_vertices = static_cast<int>(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int v : mesh.triangles[t]) {
      if (v < 0 || v >= n_vertices) {
        throw std::invalid_argument("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) +
                                    " of " + std::to_string(n_vertices));
      }
      if (!mesh.vertices[v].allFinite()) {
        throw std::invalid_argument("triangle " + std::to_string(t) + ": vertex " + std::to_string(v) + " is not finite");
      }
    }
  }
}

TriangleMesh Transform(const Pose& X_AB, const TriangleMesh& mesh_B) {
  TriangleMesh mesh_A = mesh_B;
  for (Eigen::Vector3d& v : mesh_A.vertices) v = X_AB * v;
  return mesh_A;
}

}  // namespace geond
