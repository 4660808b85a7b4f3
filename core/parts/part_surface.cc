// SPDX-License-Identifier: Apache-2.0
// The mesh prepared for segmentation: canonical order, size, noise.
#include "core/parts/part_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace geond {
namespace {

bool Before(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
}

// The vertices around each vertex, by the canonical order of the triangles; and whether it lies on a border.
struct Rings {
  std::vector<std::vector<int>> around;
  std::vector<bool> border;
};

Rings MakeRings(const TriangleMesh& mesh) {
  Rings rings;
  rings.around.resize(mesh.vertices.size());
  rings.border.assign(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      rings.around[t[k]].push_back(t[(k + 1) % 3]);
      rings.around[t[k]].push_back(t[(k + 2) % 3]);
    }
  }
  for (std::size_t v = 0; v < rings.around.size(); ++v) {
    std::vector<int>& ring = rings.around[v];
    std::sort(ring.begin(), ring.end(), [&](int a, int b) {
      return Before(mesh.vertices[a], mesh.vertices[b]) || (mesh.vertices[a] == mesh.vertices[b] && a < b);
    });
    for (std::size_t begin = 0; begin < ring.size();) {  // inside, every neighbour comes twice
      std::size_t end = begin + 1;
      while (end < ring.size() && ring[end] == ring[begin]) ++end;
      if (end - begin != 2) rings.border[v] = true;
      begin = end;
    }
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }
  return rings;
}

Eigen::Vector3d RingMean(const Rings& rings, const std::vector<Eigen::Vector3d>& values, int v) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int w : rings.around[v]) sum += values[w];
  return sum / static_cast<double>(rings.around[v].size());
}

// Centroids, area vectors, areas, borders and sizes for where the vertices now lie; `first` and `to` stand.
void UpdateShape(PartSurface& surface) {
  const TriangleMesh& mesh = surface.mesh;
  SurfaceGraph& graph = surface.graph;
  const int n = static_cast<int>(mesh.triangles.size());
  graph.centroids.resize(n);
  graph.area_vectors.resize(n);
  graph.areas.resize(n);
  graph.area = 0.0;
  for (int t = 0; t < n; ++t) {
    graph.centroids[t] = TriangleCentroid(mesh, t);
    graph.area_vectors[t] = TriangleAreaVector(mesh, t);
    graph.areas[t] = graph.area_vectors[t].norm();
    graph.area += graph.areas[t];
  }
  for (std::size_t k = 0; k < graph.to.size(); ++k) {
    const auto& [v, w] = surface.arc_ends[k];
    graph.lengths[k] = (mesh.vertices[w] - mesh.vertices[v]).norm();
    graph.middles[k] = 0.5 * (mesh.vertices[w] + mesh.vertices[v]);
  }
  graph.edge = MeanEdgeLength(mesh);
}

// 2 sqrt(3) times the rms distance of the surface from its centroid, m.
double SizeOf(const SurfaceGraph& graph) {
  if (!(graph.area > 0.0)) return 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int t = 0; t < graph.n(); ++t) centre += graph.areas[t] * graph.centroids[t];
  centre /= graph.area;
  double spread = 0.0;
  for (int t = 0; t < graph.n(); ++t) spread += graph.areas[t] * (graph.centroids[t] - centre).squaredNorm();
  return 2.0 * std::sqrt(3.0 * spread / graph.area);
}

// An arc for each triangle over each edge, and one back where an edge of more than two triangles leads one way only.
void Connect(PartSurface& surface) {
  const TriangleMesh& mesh = surface.mesh;
  SurfaceGraph& graph = surface.graph;
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  const int n = static_cast<int>(neighbors.size());
  std::map<int, std::vector<std::pair<int, int>>> ways_back;  // to a triangle: from which, over which side
  graph.at_border.assign(n, false);
  for (int t = 0; t < n; ++t) {
    for (int side = 0; side < 3; ++side) {
      const int next = neighbors[t][side];
      if (next < 0) {
        graph.at_border[t] = true;
      } else if (next != t && std::find(neighbors[next].begin(), neighbors[next].end(), t) == neighbors[next].end()) {
        ways_back[next].push_back({t, side});
      }
    }
  }
  const auto add = [&](int next, int owner, int side) {
    const TriangleMesh::Triangle& v = mesh.triangles[owner];
    graph.to.push_back(next);
    surface.arc_ends.push_back({v[side], v[(side + 1) % 3]});
  };
  graph.first.assign(1, 0);
  graph.to.reserve(3 * static_cast<std::size_t>(n));
  surface.arc_ends.reserve(3 * static_cast<std::size_t>(n));
  for (int t = 0; t < n; ++t) {
    for (int side = 0; side < 3; ++side) {
      if (neighbors[t][side] >= 0 && neighbors[t][side] != t) add(neighbors[t][side], t, side);
    }
    const auto back = ways_back.find(t);
    if (back != ways_back.end()) {
      for (const auto& [from, side] : back->second) add(from, from, side);
    }
    graph.first.push_back(static_cast<int>(graph.to.size()));
  }
  graph.lengths.resize(graph.to.size());
  graph.middles.resize(graph.to.size());
}

}  // namespace

PartSurface MakePartSurface(const TriangleMesh& mesh, double noise) {
  PartSurface surface;
  const int n = static_cast<int>(mesh.triangles.size());
  // Each triangle from its least vertex on, then all by their vertices: an order that only the geometry decides.
  std::vector<TriangleMesh::Triangle> turned = mesh.triangles;
  for (auto& t : turned) {
    int least = 0;
    for (int k = 1; k < 3; ++k) {
      if (Before(mesh.vertices[t[k]], mesh.vertices[t[least]])) least = k;
    }
    std::rotate(t.begin(), t.begin() + least, t.end());
  }
  surface.source.resize(n);
  std::iota(surface.source.begin(), surface.source.end(), 0);
  std::stable_sort(surface.source.begin(), surface.source.end(), [&](int a, int b) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d &p = mesh.vertices[turned[a][k]], &q = mesh.vertices[turned[b][k]];
      if (p != q) return Before(p, q);
    }
    return false;
  });
  surface.mesh.vertices = mesh.vertices;
  surface.mesh.triangles.resize(n);
  for (int t = 0; t < n; ++t) surface.mesh.triangles[t] = turned[surface.source[t]];
  Connect(surface);
  UpdateShape(surface);
  surface.graph.size = SizeOf(surface.graph);
  surface.noise = noise >= 0.0 ? noise : EstimateNoise(surface.mesh);
  return surface;
}

double EstimateNoise(const TriangleMesh& mesh) {
  const Rings rings = MakeRings(mesh);
  const std::vector<Eigen::Vector3d> normals = VertexNormals(mesh);
  const int n = static_cast<int>(mesh.vertices.size());
  std::vector<Eigen::Vector3d> offset(n, Eigen::Vector3d::Zero());  // of the vertex from its ring's mean
  for (int v = 0; v < n; ++v) {
    if (!rings.around[v].empty()) offset[v] = mesh.vertices[v] - RingMean(rings, mesh.vertices, v);
  }
  std::vector<double> excess;
  for (int v = 0; v < n; ++v) {
    if (rings.around[v].empty() || rings.border[v]) continue;
    const double k = static_cast<double>(rings.around[v].size());
    // For independent noise s of each vertex on a triangular lattice of valence k the variance of this second
    // difference is (1 + 1/k)^2 + about k (2/k)^2 - small terms, times s^2.
    const double variance = (1.0 + 1.0 / k) * (1.0 + 1.0 / k) + 3.0 / k;
    excess.push_back(std::abs((offset[v] - RingMean(rings, offset, v)).dot(normals[v])) / std::sqrt(variance));
  }
  if (excess.empty()) return 0.0;
  std::nth_element(excess.begin(), excess.begin() + excess.size() / 2, excess.end());
  return excess[excess.size() / 2] / 0.6745;  // the median of |x| of a normal distribution
}

void SmoothTaubin(PartSurface& surface, int steps) {
  if (steps <= 0) return;
  const Rings rings = MakeRings(surface.mesh);
  std::vector<Eigen::Vector3d>& x = surface.mesh.vertices;
  std::vector<Eigen::Vector3d> next = x;
  for (int step = 0; step < 2 * steps; ++step) {
    const double weight = step % 2 == 0 ? 0.5 : -0.53;
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (rings.around[v].empty() || rings.border[v]) continue;
      next[v] = x[v] + weight * (RingMean(rings, x, static_cast<int>(v)) - x[v]);
    }
    x.swap(next);
    next = x;
  }
  UpdateShape(surface);
}

}  // namespace geond
