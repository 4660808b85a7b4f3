// SPDX-License-Identifier: Apache-2.0
#include "core/surface/tessellate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/surface/data_surface.h"
#include "core/surface/field_mesh.h"
#include "core/surface/view_field.h"

namespace geond {
namespace {

// Mean distance of neighbouring data on a surface that faces the sensor, m.
double MeanPitch(std::span<const RangeView> views) {
  double sum = 0.0;
  std::size_t n = 0;
  for (const RangeView& view : views) {
    const double focal = std::min(std::abs(view.sensor.focal_u), std::abs(view.sensor.focal_v));
    for (std::size_t pixel = 0; pixel < view.classes.size(); ++pixel) {
      if (!view.IsObject(pixel) || !std::isfinite(view.image.depth[pixel])) continue;
      sum += (view.sensor.projection == SensorModel::Projection::kPerspective ? view.image.depth[pixel] : 1.0) / focal;
      ++n;
    }
  }
  return n > 0 ? sum / static_cast<double>(n) : 0.0;
}

double MeanNoise(std::span<const RangeView> views) {
  double sum = 0.0;
  for (const RangeView& view : views) sum += view.sensor.depth_noise;
  return sum / static_cast<double>(views.size());
}

// Signed distance of the views on a grid, the unknown filled in, cut by the table.
SignedGrid ViewDistances(std::span<const RangeView> views, const Eigen::AlignedBox3d& box, double voxel,
                         const TessellateOptions& options, const std::stop_token& stop) {
  Eigen::AlignedBox3d bounds(box.min().array() - 2 * voxel, box.max().array() + 2 * voxel);
  if (options.close_on_table) bounds.min().z() = 0.0;
  ViewField field = FuseViews(views, SignedGrid(bounds, voxel, 0.0f), 2.0 * voxel, options.threads, stop);
  DiffuseUnknown(field, options.close_on_table, options.threads, stop);
  if (options.close_on_table) CutByTable(field.distance);
  return std::move(field.distance);
}

}  // namespace

TriangleMesh Tessellate(std::span<const RangeView> views, const PointCloud& merged, const TessellateOptions& options,
                        std::stop_token stop) {
  if (views.empty() || merged.size() < 10) {
    throw std::invalid_argument("Tessellate: there is nothing to mesh (" + std::to_string(views.size()) + " views, " +
                                std::to_string(merged.size()) + " points of the object)");
  }
  const double pitch = MeanPitch(views);
  const Eigen::AlignedBox3d box = BoundingBox(merged.points);
  double voxel = options.voxel_size;
  if (!(voxel > 0.0)) voxel = VoxelSize(pitch, box, options);

  TriangleMesh mesh;
  SignedGrid grid;
  // A handle narrower than the voxels can tell comes and goes with their size: what coarser ones do not show is taken for
  // noise.
  for (int attempt = 0; attempt < 3; ++attempt) {
    ThrowIfStopped(stop);
    SignedGrid coarser = ViewDistances(views, box, voxel * std::pow(1.35, attempt), options, stop);
    TriangleMesh candidate = LargeComponents(MarchingTetrahedra(coarser));
    if (attempt > 0 && Topology(candidate).genus >= Topology(mesh).genus) break;
    mesh = std::move(candidate);
    grid = std::move(coarser);
    if (mesh.empty()) throw std::invalid_argument("Tessellate: the views enclose nothing; are they registered?");
    if (Topology(mesh).genus == 0) break;
  }
  const SurfaceProjection on_field = FieldProjection(grid, options.close_on_table);
  const RemeshOptions remesh{.triangles = options.triangles, .edge_length = options.edge_length, .threads = options.threads};
  mesh = RemeshOnto(mesh, on_field, remesh, stop);

  const DataSurface data(CreaseAwareCloud(views, options.threads), MeanNoise(views), options.threads);
  const double edge = MeanEdgeLength(mesh), attraction = 0.5 * edge;
  const auto on_data = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) -> Eigen::Vector3d {
    if (!options.close_on_table || p.z() > 0.35 * edge) {
      const auto foot = data.Project(p, normal, attraction);
      return foot ? foot->point : on_field(p, normal);
    }
    // On the table: the bottom stays flat, and what stands on its rim goes down to the table along the wall.
    Eigen::Vector3d sideways(normal.x(), normal.y(), 0.0);
    if (sideways.norm() < 0.3) return {p.x(), p.y(), 0.0};
    const auto foot = data.Project({p.x(), p.y(), std::max(p.z(), 0.5 * edge)}, sideways.normalized(), 0.0);
    if (!foot || std::abs(foot->normal.z()) > 0.7) return on_field(p, normal);
    const Eigen::Vector3d down = foot->normal.z() * foot->normal - Eigen::Vector3d::UnitZ();  // along the wall
    const Eigen::Vector3d at = foot->point - down * (foot->point.z() / down.z());
    return {at.x(), at.y(), 0.0};
  };
  mesh = RelaxOnto(mesh, on_data, 4, options.threads, stop);
  MarkSeen(mesh, merged.points, 3.0 * pitch, options.threads);
  return mesh;
}

}  // namespace geond
