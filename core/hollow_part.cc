// SPDX-License-Identifier: Apache-2.0
#include "core/hollow_part.h"

#include <vector>

#include <Eigen/Geometry>

#include "core/part_clouds.h"

namespace geond {
namespace {

constexpr std::size_t kMostTriangles = 6000;             // finer meshes come of one view, whose far side is a guess
constexpr double kLeastHollow = 0.2, kMostHollow = 0.7;  // share of the part's area

// Whether a ray meets a triangle beyond `nearest` (Moeller and Trumbore 1997).
bool Meets(const Eigen::Vector3d& from, const Eigen::Vector3d& direction, const TriangleMesh& mesh, int triangle,
           double nearest) {
  const auto& [ia, ib, ic] = mesh.triangles[triangle];
  const Eigen::Vector3d &a = mesh.vertices[ia], ab = mesh.vertices[ib] - a, ac = mesh.vertices[ic] - a;
  const Eigen::Vector3d h = direction.cross(ac);
  const double determinant = ab.dot(h);
  if (determinant == 0.0) return false;
  const Eigen::Vector3d s = from - a, q = s.cross(ab);
  const double u = s.dot(h) / determinant, v = direction.dot(q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > nearest;
}

}  // namespace

PointCloud OutsideOfPart(const PointCloud& cloud, const TriangleMesh& mesh, const PartSegmentation& segmentation,
                         int part) {
  std::vector<int> own;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    if (segmentation.labels[t] == part) own.push_back(t);
  }
  if (own.size() > kMostTriangles) return {};
  const double skin = 1e-6 * MeanEdgeLength(mesh);
  PartSegmentation outside = segmentation;
  double area = 0.0, hollow = 0.0;
  for (int t : own) {
    const Eigen::Vector3d area_vector = TriangleAreaVector(mesh, t), normal = area_vector.stableNormalized();
    const Eigen::Vector3d from = TriangleCentroid(mesh, t);
    area += area_vector.norm();
    for (int other : own) {
      if (other == t || !Meets(from, normal, mesh, other, skin)) continue;
      outside.labels[t] = -1;
      hollow += area_vector.norm();
      break;
    }
  }
  if (!(hollow >= kLeastHollow * area && hollow <= kMostHollow * area)) return {};
  return PartClouds(cloud, mesh, outside)[part];
}

}  // namespace geond
