// SPDX-License-Identifier: Apache-2.0
#include "core/part_clouds.h"

#include "core/geometry/point_index.h"

namespace geond {
namespace {

constexpr int kFewestPoints = 30;
// A part keeps the points beside its cuts if without them less than this share is left.
constexpr double kLeastShare = 0.5;

}  // namespace

std::vector<PointCloud> PartClouds(const PointCloud& cloud, const TriangleMesh& mesh,
                                   const PartSegmentation& segmentation) {
  std::vector<Eigen::Vector3d> centroids(mesh.triangles.size());
  for (std::size_t t = 0; t < centroids.size(); ++t) centroids[t] = TriangleCentroid(mesh, static_cast<int>(t));
  const PointIndex triangles(centroids);
  std::vector<Eigen::Vector3d> cut;
  for (const auto& places : PartCuts(mesh, segmentation)) cut.insert(cut.end(), places.begin(), places.end());
  const PointIndex cuts(cut);
  const double band = MeanEdgeLength(mesh);

  PointCloud oriented = cloud;
  if (!cloud.has_normals()) oriented.normals.resize(cloud.size());
  std::vector<std::vector<int>> all(segmentation.n_parts), away_from_cuts(segmentation.n_parts);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int triangle = triangles.Nearest(cloud.points[i], 1).front().first;
    if (!cloud.has_normals()) oriented.normals[i] = TriangleAreaVector(mesh, triangle).stableNormalized();
    const int label = segmentation.labels[triangle];
    if (label < 0) continue;
    all[label].push_back(static_cast<int>(i));
    if (cut.empty() || cuts.Nearest(cloud.points[i], 1).front().second > band * band) {
      away_from_cuts[label].push_back(static_cast<int>(i));
    }
  }

  std::vector<PointCloud> parts;
  for (int part = 0; part < segmentation.n_parts; ++part) {
    const bool enough = static_cast<double>(away_from_cuts[part].size()) >= kLeastShare * static_cast<double>(all[part].size());
    parts.push_back(Select(oriented, enough ? away_from_cuts[part] : all[part]));
  }
  return parts;
}

std::vector<std::vector<Eigen::Vector3d>> PartCuts(const TriangleMesh& mesh, const PartSegmentation& segmentation) {
  std::vector<std::vector<Eigen::Vector3d>> cuts(segmentation.n_parts);
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  const std::vector<int>& labels = segmentation.labels;
  for (std::size_t t = 0; t < labels.size(); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int other = neighbors[t][side];
      if (labels[t] < 0 || other < 0 || labels[t] == labels[other]) continue;
      cuts[labels[t]].push_back(0.5 * (mesh.vertices[mesh.triangles[t][side]] + mesh.vertices[mesh.triangles[t][(side + 1) % 3]]));
    }
  }
  return cuts;
}

std::vector<GeonFit> FitPart(const PointCloud& part, const Surroundings& around, const FitOptions& options,
                             std::stop_token stop) {
  if (static_cast<int>(part.size()) < kFewestPoints || !part.has_normals()) return {};
  return FitGeons(part, options, stop, {}, around);
}

}  // namespace geond
