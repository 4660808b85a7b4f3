// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

namespace geond {

// How a pixel (column u to the right, row v down, centres at whole numbers) and a depth z along the optical axis become a
// point in S (origin at the centre of projection; x right, y down, z out of the window), and back.
//   perspective:  x = (u - center_u) z / focal_u      orthographic:  x = (u - center_u) / focal_u
// (and the same in v), so focal is in pixels for the one, in pixels a metre for the other.
struct SensorModel {
  enum class Projection { kPerspective, kOrthographic };
  Projection projection = Projection::kPerspective;
  int columns = 0;
  int rows = 0;
  double focal_u = 1.0;
  double focal_v = 1.0;
  double center_u = 0.0;
  double center_v = 0.0;
  double min_depth = 0.0;   // m
  double max_depth = 1e3;   // m
  double depth_noise = 0.0;  // standard deviation along the ray at normal incidence, m; 0: unknown

  bool operator==(const SensorModel&) const = default;
};

// p_S of a pixel at depth z (m).
Eigen::Vector3d Unproject(const SensorModel& sensor, double column, double row, double depth);
// Unit direction in S from the sensor through a pixel.
Eigen::Vector3d RayDirection(const SensorModel& sensor, double column, double row);
// (column, row) of a point in S, also outside the image; none if it lies behind a perspective sensor.
std::optional<Eigen::Vector2d> Project(const SensorModel& sensor, const Eigen::Vector3d& p_S);

}  // namespace geond
