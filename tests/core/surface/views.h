// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "core/range/range_view.h"

namespace geond {

// Where a ray from `from` (T) along the unit `direction` meets the object first: distance and outward normal.
struct RayHit {
  double distance;
  Eigen::Vector3d normal_T;
};
using Object = std::function<std::optional<RayHit>(const Eigen::Vector3d& from, const Eigen::Vector3d& direction)>;

inline Object SphereObject(const Eigen::Vector3d& center, double radius) {
  return [=](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) -> std::optional<RayHit> {
    const Eigen::Vector3d to = from - center;
    const double b = to.dot(direction), q = b * b - to.squaredNorm() + radius * radius;
    if (q < 0.0) return std::nullopt;
    const double distance = -b - std::sqrt(q);
    return RayHit{distance, (to + distance * direction) / radius};
  };
}

// The box |x| <= a.x, |y| <= a.y, 0 <= z <= a.z.
inline Object BoxObject(const Eigen::Vector3d& a) {
  return [=](const Eigen::Vector3d& from, const Eigen::Vector3d& direction) -> std::optional<RayHit> {
    const Eigen::Vector3d low(-a.x(), -a.y(), 0.0);
    double enter = 0.0, leave = 1e9;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      double t0 = (low[k] - from[k]) / direction[k], t1 = (a[k] - from[k]) / direction[k];
      const double side = t0 < t1 ? -1.0 : 1.0;
      if (t0 > t1) std::swap(t0, t1);
      if (t0 > enter) {
        enter = t0;
        normal = side * Eigen::Vector3d::Unit(k);
      }
      leave = std::min(leave, t1);
    }
    if (!(enter < leave) || enter <= 0.0) return std::nullopt;
    return RayHit{enter, normal};
  };
}

// Pose in T of a sensor `distance` away from `at`, turned about z by `angle` and up by `elevation` (rad), looking there.
inline Pose LookingAt(const Eigen::Vector3d& at, double distance, double angle, double elevation) {
  const Eigen::Vector3d out(std::cos(elevation) * std::cos(angle), std::cos(elevation) * std::sin(angle), std::sin(elevation));
  Eigen::Matrix3d R;
  R.col(2) = -out;
  R.col(0) = -out.cross(Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {R, at + distance * out};
}

// A view without noise of an object on the table z = 0 (or hanging free), with its true normals.
inline RangeView MakeView(const Object& object, const Pose& X_TS, int size, double field_of_view, bool table = true) {
  RangeView view;
  view.sensor.columns = view.sensor.rows = size;
  view.sensor.focal_u = view.sensor.focal_v = 0.5 * size / std::tan(0.5 * field_of_view);
  view.sensor.center_u = view.sensor.center_v = 0.5 * (size - 1);
  view.image.columns = view.image.rows = size;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  view.image.depth.assign(size * size, nan);
  view.classes.assign(size * size, PixelClass::kNothing);
  view.normals_S.assign(size * size, Eigen::Vector3f::Constant(nan));
  view.normal_residuals.assign(size * size, nan);
  view.X_TS = view.X_TS_measured = X_TS;
  const Eigen::Vector3d from = X_TS.translation();
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const Eigen::Vector3d ray_S = RayDirection(view.sensor, column, row), ray = X_TS.Rotate(ray_S);
      const std::size_t pixel = view.image.index(column, row);
      const std::optional<RayHit> hit = object(from, ray);
      if (hit && -hit->normal_T.dot(ray) > 0.15) {
        view.image.depth[pixel] = static_cast<float>(hit->distance * ray_S.z());
        view.classes[pixel] = PixelClass::kObject;
        view.normals_S[pixel] = Inverse(X_TS).Rotate(hit->normal_T).cast<float>();
        view.normal_residuals[pixel] = 1e-5f;
      } else if (hit) {
        view.classes[pixel] = PixelClass::kRejected;
      } else if (table && ray.z() < -1e-3) {
        view.image.depth[pixel] = static_cast<float>(-from.z() / ray.z() * ray_S.z());
        view.classes[pixel] = PixelClass::kTable;
      } else {
        view.classes[pixel] = PixelClass::kBackground;
      }
    }
  }
  return view;
}

}  // namespace geond
