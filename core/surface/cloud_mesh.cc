// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/cloud_normals.h"
#include "core/surface/field_mesh.h"
#include "core/surface/orient_cloud.h"
#include "core/geometry/point_index.h"
#include "core/surface/tessellate.h"
#include "core/surface/winding_field.h"
#include "core/surface/winding_number.h"

namespace geond {
namespace {

// One point a cell of this size: the mean of what lies in it. Normals are averaged too, if they are worth it.
PointCloud Thinned(const PointCloud& cloud, double cell, bool keep_normals) {
  using Key = std::tuple<std::int64_t, std::int64_t, std::int64_t>;
  std::vector<std::pair<Key, int>> order;
  order.reserve(cloud.size());
  for (int i = 0; i < static_cast<int>(cloud.size()); ++i) {
    const Eigen::Vector3d& p = cloud.points[i];
    if (!p.allFinite()) continue;
    order.emplace_back(Key(std::llround(p.x() / cell), std::llround(p.y() / cell), std::llround(p.z() / cell)), i);
  }
  std::sort(order.begin(), order.end());
  PointCloud thinned;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), n = Eigen::Vector3d::Zero();
    for (; end < order.size() && order[end].first == order[begin].first; ++end) {
      p += cloud.points[order[end].second];
      if (keep_normals) n += cloud.normals[order[end].second];
    }
    // Two faces of an edge or a sheet in one cell cancel out: then the first one stands for both.
    if (keep_normals && n.norm() < 0.3 * static_cast<double>(end - begin)) n = cloud.normals[order[begin].second];
    thinned.points.push_back(p / static_cast<double>(end - begin));
    if (keep_normals) thinned.normals.push_back(n.normalized());
    begin = end;
  }
  return thinned;
}

// Distance to the tenth neighbour of each point.
std::vector<double> Reaches(const PointCloud& cloud, const PointIndex& index, int threads) {
  std::vector<double> reaches(cloud.size());
  ParallelFor(static_cast<std::ptrdiff_t>(cloud.size()), threads, 256, [&](std::ptrdiff_t i) {
    reaches[i] = std::sqrt(index.Nearest(cloud.points[i], 11).back().second);
  });
  return reaches;
}

double Quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Each point stands for its share of the disc of its ten neighbours; normals times that area.
std::vector<Eigen::Vector3d> AreaVectors(const PointCloud& cloud, const std::vector<double>& reaches) {
  std::vector<Eigen::Vector3d> areas(cloud.size());
  for (std::size_t i = 0; i < areas.size(); ++i) areas[i] = cloud.normals[i] * (std::numbers::pi * reaches[i] * reaches[i] / 10.5);
  return areas;
}

}  // namespace

TriangleMesh TessellateCloud(const PointCloud& input, const TessellateOptions& options, std::stop_token stop) {
  constexpr int kFewest = 60;
  PointCloud cloud = Thinned(input, 1e-12, false);
  if (static_cast<int>(cloud.size()) < kFewest) {
    throw std::invalid_argument("the cloud has " + std::to_string(cloud.size()) + " points; a closed mesh needs at least " +
                                std::to_string(kFewest));
  }
  const Eigen::AlignedBox3d box = BoundingBox(cloud.points);
  // Ten neighbours on a square grid lie within some 1.8 of its pitch.
  double pitch = 0.0;
  {
    const PointIndex index(cloud.points);
    pitch = Quantile(Reaches(cloud, index, options.threads), 0.75) / 1.8;
  }
  ThrowIfStopped(stop);
  const double voxel = options.voxel_size > 0.0 ? options.voxel_size : VoxelSize(pitch, box, options);
  const bool keep_normals = input.has_normals() && NormalsAgree(input, options.threads);
  cloud = Thinned(input, 0.6 * voxel, keep_normals);
  ThrowIfStopped(stop);
  if (static_cast<int>(cloud.size()) < kFewest) throw std::invalid_argument("the cloud is too small for voxels of this size");
  if (!keep_normals) cloud = OrientOutward(EstimateCloudNormals(std::move(cloud), 14, options.threads), options.threads);
  ThrowIfStopped(stop);

  const PointIndex index(cloud.points);
  const std::vector<double> reaches = Reaches(cloud, index, options.threads);
  const std::vector<Eigen::Vector3d> areas = AreaVectors(cloud, reaches);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (const Eigen::Vector3d& a : areas) sum += a, total += a.norm();
  if (sum.norm() > 0.45 * total) {
    throw std::invalid_argument("the cloud shows its object from one side only (" +
                                std::to_string(static_cast<int>(100.0 * sum.norm() / total)) +
                                " % of its surface faces one way); it cannot be closed without views from the others");
  }

  const WindingNumber winding(cloud.points, areas);
  // Mean distance to the planes of the points around p (an implicit least-squares surface, Kolluri 2005).
  const double width = std::max(voxel, 0.6 * Quantile(reaches, 0.5));
  const double reach = 1.5 * width;
  const auto signed_distance = [&](const Eigen::Vector3d& p, const std::function<double()>&) -> std::optional<double> {
    const PointIndex::Neighbors near = index.Within(p, 2.5 * width);
    if (near.empty() || near[0].second > reach * reach) return std::nullopt;
    double weighted = 0.0, weights = 0.0;
    for (const auto& [i, squared] : near) {
      const double w = std::exp(-squared / (width * width));
      weighted += w * cloud.normals[i].dot(p - cloud.points[i]);
      weights += w;
    }
    return weighted / weights;
  };
  const auto distance = [&](const Eigen::Vector3d& p, double limit) { return std::min(limit, std::sqrt(index.Nearest(p, 1)[0].second)); };
  const double margin = 3.0 * voxel;
  const Eigen::AlignedBox3d bounds(box.min().array() - margin, box.max().array() + margin);
  const SignedGrid grid = WindingField(SignedGrid(bounds, voxel, 0.0f), winding,
                                       {distance, signed_distance, reach}, options.threads, stop);
  const TriangleMesh raw = LargeComponents(MarchingTetrahedra(grid));
  if (raw.empty()) throw std::invalid_argument("the cloud encloses nothing: its points lie on no surface that goes round");
  TriangleMesh mesh = RemeshOnto(raw, FieldProjection(grid, false),
                                 {.triangles = options.triangles, .edge_length = options.edge_length, .threads = options.threads}, stop);
  MarkSeen(mesh, cloud.points, 1.5 * width, options.threads);

  const MeshTopology topology = Topology(mesh);
  const double seen = static_cast<double>(std::count(mesh.triangle_seen.begin(), mesh.triangle_seen.end(), 1)) /
                      static_cast<double>(mesh.triangles.size());
  if (topology.components > 1 || topology.genus > 20 || seen < 0.5) {
    throw std::invalid_argument("the cloud cannot be closed sensibly: its points give " + std::to_string(topology.components) +
                                " surfaces with " + std::to_string(topology.genus) + " holes through, " +
                                std::to_string(static_cast<int>(100.0 * seen)) +
                                " % of which lie near data; it is too sparse, too noisy or its normals are wrong");
  }
  return mesh;
}

}  // namespace geond
