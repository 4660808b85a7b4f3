// SPDX-License-Identifier: Apache-2.0
// The mesh prepared for segmentation: canonical order, size, noise, smoothing, and means over balls of the surface.
#include "core/parts/part_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

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

}  // namespace

double PartSurface::EdgeLength(int triangle, int side) const {
  const auto& t = mesh.triangles[triangle];
  return (mesh.vertices[t[(side + 1) % 3]] - mesh.vertices[t[side]]).norm();
}

Eigen::Vector3d PartSurface::EdgeMiddle(int triangle, int side) const {
  const auto& t = mesh.triangles[triangle];
  return 0.5 * (mesh.vertices[t[(side + 1) % 3]] + mesh.vertices[t[side]]);
}

void UpdateShape(PartSurface& surface) {
  const int n = static_cast<int>(surface.mesh.triangles.size());
  surface.centroids.resize(n);
  surface.area_vectors.resize(n);
  surface.areas.resize(n);
  surface.area = 0.0;
  for (int t = 0; t < n; ++t) {
    surface.centroids[t] = TriangleCentroid(surface.mesh, t);
    surface.area_vectors[t] = TriangleAreaVector(surface.mesh, t);
    surface.areas[t] = surface.area_vectors[t].norm();
    surface.area += surface.areas[t];
  }
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int t = 0; t < n; ++t) centre += surface.areas[t] * surface.centroids[t];
  if (surface.area > 0.0) centre /= surface.area;
  double spread = 0.0;
  for (int t = 0; t < n; ++t) spread += surface.areas[t] * (surface.centroids[t] - centre).squaredNorm();
  surface.size = surface.area > 0.0 ? 2.0 * std::sqrt(3.0 * spread / surface.area) : 0.0;
  surface.edge = MeanEdgeLength(surface.mesh);
}

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
  surface.neighbors = TriangleNeighbors(surface.mesh);
  UpdateShape(surface);
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
  const double size = surface.size;
  UpdateShape(surface);
  surface.size = size;
}

const std::vector<int>& BallWalk::Collect(int seed, const Eigen::Vector3d& centre, double radius) {
  return Collect(seed, seed, centre, radius);
}

const std::vector<int>& BallWalk::Collect(int seed, int second_seed, const Eigen::Vector3d& centre, double radius) {
  if (++now_ == 0) {
    std::fill(stamp_.begin(), stamp_.end(), 0);
    now_ = 1;
  }
  found_.clear();
  for (int s : {seed, second_seed}) {
    if (stamp_[s] == now_) continue;
    stamp_[s] = now_;
    found_.push_back(s);
  }
  const double limit = radius * radius;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    for (int next : surface_.neighbors[found_[i]]) {
      if (next < 0 || stamp_[next] == now_) continue;
      stamp_[next] = now_;
      if ((surface_.centroids[next] - centre).squaredNorm() <= limit) found_.push_back(next);
    }
  }
  return found_;
}

std::vector<double> BallMean(const PartSurface& surface, const std::vector<double>& values, double radius) {
  std::vector<double> means(values.size());
  BallWalk walk(surface);
  for (int t = 0; t < surface.n(); ++t) {
    double sum = 0.0, area = 0.0;
    for (int k : walk.Collect(t, surface.centroids[t], radius)) {
      sum += surface.areas[k] * values[k];
      area += surface.areas[k];
    }
    means[t] = area > 0.0 ? sum / area : values[t];
  }
  return means;
}

}  // namespace geond
