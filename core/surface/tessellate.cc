// SPDX-License-Identifier: Apache-2.0
#include "core/surface/tessellate.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "core/base/parallel.h"
#include "core/base/progress.h"
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

  TriangleMesh best;
  for (int attempt = 0; attempt < 3; ++attempt) {
    ThrowIfStopped(stop);
    const double truncation = 3.0 * voxel;
    Eigen::AlignedBox3d bounds(box.min().array() - 2 * voxel, box.max().array() + 2 * voxel);
    if (options.close_on_table) bounds.min().z() = 0.0;
    ViewField field = FuseViews(views, SignedGrid(bounds, voxel, 0.0f), truncation, options.threads, stop);
    DiffuseUnknown(field, options.close_on_table, options.threads, stop);
    if (options.close_on_table) CutByTable(field.distance);
    TriangleMesh mesh = LargeComponents(MarchingTetrahedra(field.distance));
    if (mesh.empty()) throw std::invalid_argument("Tessellate: the views enclose nothing; are they registered?");
    const auto project = FieldProjection(field.distance, options.close_on_table);
    RemeshOptions remesh{.triangles = options.triangles, .edge_length = options.edge_length, .threads = options.threads};
    best = RemeshOnto(mesh, project, remesh, stop);
    break;
  }
  MarkSeen(best, merged.points, 3.0 * pitch, options.threads);
  return best;
}

}  // namespace geond
