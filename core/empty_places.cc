// SPDX-License-Identifier: Apache-2.0
#include "core/empty_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "core/surface/winding_number.h"

namespace geond {
namespace {

constexpr int kEvenly = 400, kNear = 800, kMost = 640;
constexpr double kBeyondBox = 0.6;                        // of its sides, on each side
constexpr double kNearRadii[] = {0.03, 0.06, 0.12, 0.2};  // of the part's diagonal, from its points

// Candidates: an even sequence over the box and its neighbourhood, and places about the points in all directions.
std::vector<Eigen::Vector3d> Candidates(const PointCloud& part) {
  const Eigen::AlignedBox3d box = BoundingBox(part.points);
  const Eigen::Vector3d low = box.min() - kBeyondBox * box.sizes(), size = (1.0 + 2.0 * kBeyondBox) * box.sizes();
  std::vector<Eigen::Vector3d> places;
  const double step = 1.0 / 1.2207440846057594754;  // of the even sequence in three dimensions
  for (int i = 0; i < kEvenly; ++i) {
    const Eigen::Vector3d share(std::fmod(0.5 + i * step, 1.0), std::fmod(0.5 + i * step * step, 1.0),
                                std::fmod(0.5 + i * step * step * step, 1.0));
    places.push_back(low + size.cwiseProduct(share));
  }
  const double diagonal = box.diagonal().norm(), golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kNear; ++i) {
    const double z = 1.0 - 2.0 * std::fmod(0.5 + i * step, 1.0), r = std::sqrt(std::max(0.0, 1.0 - z * z));
    const Eigen::Vector3d direction(r * std::cos(golden * i), r * std::sin(golden * i), z);
    const std::size_t at = static_cast<std::size_t>(i) * part.size() / kNear;
    places.push_back(part.points[at] + kNearRadii[i % 4] * diagonal * direction);
  }
  return places;
}

template <typename IsEmpty>
std::vector<Eigen::Vector3d> Those(const PointCloud& part, const IsEmpty& is_empty) {
  std::vector<Eigen::Vector3d> empty;
  if (part.empty()) return empty;
  for (const Eigen::Vector3d& p : Candidates(part))
    if (is_empty(p)) empty.push_back(p);
  if (empty.size() <= kMost) return empty;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < kMost; ++i) some.push_back(empty[(2 * i + 1) * empty.size() / (2 * kMost)]);
  return some;
}

// Whether a view looked past a point at something behind it: all nine pixels around say so.
bool LooksThrough(const RangeView& view, const Eigen::Vector3d& p_S) {
  const auto at = Project(view.sensor, p_S);
  if (!at || p_S.z() <= 0.0) return false;
  const int column = static_cast<int>(std::lround(at->x())), row = static_cast<int>(std::lround(at->y()));
  const double focal = std::min(view.sensor.focal_u, view.sensor.focal_v);
  const double pitch = view.sensor.projection == SensorModel::Projection::kPerspective ? p_S.z() / focal : 1.0 / focal;
  const double margin = std::max(2.0 * pitch, 4.0 * view.sensor.depth_noise);
  for (int k = 0; k < 9; ++k) {
    const int c = column + k % 3 - 1, r = row + k / 3 - 1;
    if (!view.image.contains(c, r)) return false;
    const std::size_t pixel = view.image.index(c, r);
    const double depth = view.image.depth[pixel];
    switch (view.classes[pixel]) {
      case PixelClass::kNothing:
        return false;
      case PixelClass::kBackground:
        if (std::isfinite(depth) && p_S.z() > depth - margin) return false;
        break;
      case PixelClass::kTable:
      case PixelClass::kObject:
        if (!(p_S.z() < depth - margin)) return false;
        break;
      case PixelClass::kRejected:
        if (!(p_S.z() < depth - 4.0 * margin)) return false;
        break;
    }
  }
  return true;
}

}  // namespace

std::vector<Eigen::Vector3d> EmptyPlaces(std::span<const RangeView> views, bool on_table, const PointCloud& part) {
  std::vector<Pose> X_ST;
  for (const RangeView& view : views) X_ST.push_back(Inverse(view.X_TS));
  const double under = on_table && !part.empty() ? -0.005 * BoundingBox(part.points).diagonal().norm() : -1e300;
  return Those(part, [&](const Eigen::Vector3d& p) {
    if (p.z() < under) return true;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (LooksThrough(views[v], X_ST[v] * p)) return true;
    return false;
  });
}

std::vector<Eigen::Vector3d> EmptyPlaces(const TriangleMesh& closed, const PointCloud& part) {
  const WindingNumber winding(closed);
  return Those(part, [&](const Eigen::Vector3d& p) { return winding.At(p) < 0.1; });
}

}  // namespace geond
