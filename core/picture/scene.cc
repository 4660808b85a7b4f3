// SPDX-License-Identifier: Apache-2.0
#include "core/picture/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/picture/view.h"

namespace geond {
namespace {

// The edges for which keep(triangle, triangle over the edge or -1) holds, each once.
template <typename Keep>
std::vector<Segment> Edges(const TriangleMesh& mesh, const Keep& keep) {
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  std::vector<Segment> segments;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int other = neighbors[t][side];
      if ((other >= 0 && other < t) || !keep(t, other)) continue;
      segments.push_back({mesh.vertices[mesh.triangles[t][side]], mesh.vertices[mesh.triangles[t][(side + 1) % 3]]});
    }
  }
  return segments;
}

std::vector<Eigen::Vector3d> PointsOf(const std::vector<const Scene*>& scenes) {
  std::vector<Eigen::Vector3d> points;
  for (const Scene* scene : scenes) {
    for (const Scene::Mesh& mesh : scene->meshes)
      points.insert(points.end(), mesh.mesh.vertices.begin(), mesh.mesh.vertices.end());
    for (const Scene::Cloud& cloud : scene->clouds)
      points.insert(points.end(), cloud.cloud.points.begin(), cloud.cloud.points.end());
    for (const Scene::Lines& lines : scene->lines) {
      for (const Segment& segment : lines.segments) points.insert(points.end(), {segment.from, segment.to});
    }
  }
  return points;
}

}  // namespace

std::vector<Segment> CreaseSegments(const TriangleMesh& mesh, double angle) {
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(mesh);
  return Edges(mesh, [&](int t, int other) { return other < 0 || normals[t].dot(normals[other]) < std::cos(angle); });
}

std::vector<Segment> BorderSegments(const TriangleMesh& mesh, const std::vector<int>& labels) {
  if (labels.size() != mesh.triangles.size())
    throw std::invalid_argument("BorderSegments: one label a triangle is wanted");
  return Edges(mesh, [&](int t, int other) { return other >= 0 && labels[t] != labels[other]; });
}

std::vector<Segment> WireSegments(const TriangleMesh& mesh) {
  return Edges(mesh, [](int, int) { return true; });
}

Camera Framing(const std::vector<const Scene*>& scenes, double azimuth, double elevation, double aspect,
               double margin) {
  const std::vector<Eigen::Vector3d> points = PointsOf(scenes);
  if (points.empty()) throw std::invalid_argument("Framing: there is nothing to look at");
  Camera camera;
  camera.azimuth = azimuth;
  camera.elevation = elevation;
  const Eigen::AlignedBox3d box = BoundingBox(points);
  camera.target = box.center();
  const double radius = std::max(0.5 * box.diagonal().norm(), 1e-9);
  const double tan_short = std::tan(0.5 * camera.field_of_view) * (1.0 - 2.0 * margin);
  const double tan_u = tan_short * std::max(1.0, aspect), tan_v = tan_short * std::max(1.0, 1.0 / aspect);
  const Eigen::Matrix3d rotation = ViewRotation(azimuth, elevation);
  // Far enough for every point; then the target moves to the middle of what is seen. A few rounds settle both.
  for (int round = 0; round < 8; ++round) {
    camera.distance = 1e-9;
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3d q = rotation * (p - camera.target);
      camera.distance = std::max({camera.distance, q.z() + std::abs(q.x()) / tan_u, q.z() + std::abs(q.y()) / tan_v});
    }
    camera.distance = std::max(camera.distance, 1.2 * radius);
    Eigen::AlignedBox2d seen;
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3d q = rotation * (p - camera.target);
      seen.extend(Eigen::Vector2d(q.head<2>() / (camera.distance - q.z())));
    }
    const Eigen::Vector2d shift = seen.center() * camera.distance;
    camera.target += rotation.transpose() * Eigen::Vector3d(shift.x(), shift.y(), 0.0);
  }
  return camera;
}

}  // namespace geond
