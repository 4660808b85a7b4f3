// SPDX-License-Identifier: Apache-2.0
#include "sim/range_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/base/parallel.h"
#include "sim/random.h"

namespace geond::sim {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// The wall stands where the sensor looks, seen from above; none if it looks straight down.
Eigen::Vector3d WallDirection(const Pose& X_TS) {
  Eigen::Vector3d direction = X_TS.Rotate(Eigen::Vector3d::UnitZ());
  direction.z() = 0.0;
  const double length = direction.norm();
  return length > 1e-6 ? Eigen::Vector3d(direction / length) : Eigen::Vector3d::Zero();
}

struct PixelRay {
  Ray ray_T;
  double depth_per_range;  // z of the unit direction in S
};

PixelRay RayOfPixel(const SensorModel& sensor, const Pose& X_TS, const Eigen::Matrix3d& R_TS, int column, int row) {
  const Eigen::Vector3d direction_S = RayDirection(sensor, column, row);
  const Eigen::Vector3d origin_S = sensor.projection == SensorModel::Projection::kOrthographic
                                       ? Unproject(sensor, column, row, 0.0)
                                       : Eigen::Vector3d::Zero();
  return {{X_TS * origin_S, R_TS * direction_S}, direction_S.z()};
}

}  // namespace

CameraOptions CameraOptions::Perfect() {
  CameraOptions options;
  options.dropout_begin = options.dropout_end = 2.0;
  options.mixed_pixel_probability = 0.0;
  options.depth_quantum = 0.0;
  return options;
}

double TrueDepth(const SceneGeometry& scene, const SensorModel& sensor, const Pose& X_TS, int column, int row) {
  const PixelRay pixel = RayOfPixel(sensor, X_TS, X_TS.matrix(), column, row);
  const SceneGeometry::Hit hit = scene.Cast(pixel.ray_T, WallDirection(X_TS));
  const double depth = hit.t * pixel.depth_per_range;
  return hit.surface != SceneGeometry::Surface::kNothing && depth >= sensor.min_depth && depth <= sensor.max_depth
             ? depth
             : kNaN;
}

RangeImage TakeRangeImage(const SceneGeometry& scene, const SensorModel& sensor, const Pose& X_TS,
                          const CameraOptions& options, std::uint64_t seed, std::uint64_t frame, int threads) {
  if (sensor.columns <= 0 || sensor.rows <= 0) throw std::invalid_argument("TakeRangeImage: the sensor has no pixels");
  const int columns = sensor.columns, rows = sensor.rows;
  RangeImage image{columns, rows, std::vector<float>(static_cast<std::size_t>(columns) * rows)};
  struct Seen {
    double range, depth, cos_incidence;
  };
  std::vector<Seen> seen(image.depth.size());
  const Eigen::Vector3d wall = WallDirection(X_TS);
  const Eigen::Matrix3d R_TS = X_TS.matrix();
  ParallelFor(rows, threads, 4, [&](std::ptrdiff_t row) {
    for (int column = 0; column < columns; ++column) {
      const PixelRay pixel = RayOfPixel(sensor, X_TS, R_TS, column, static_cast<int>(row));
      const SceneGeometry::Hit hit = scene.Cast(pixel.ray_T, wall);
      const bool any = hit.surface != SceneGeometry::Surface::kNothing;
      seen[image.index(column, static_cast<int>(row))] = {
          any ? hit.t : kNaN, any ? hit.t * pixel.depth_per_range : kNaN, hit.cos_incidence};
    }
  });
  ParallelFor(rows, threads, 4, [&](std::ptrdiff_t row) {
    for (int column = 0; column < columns; ++column) {
      const std::size_t index = image.index(column, static_cast<int>(row));
      const Seen& here = seen[index];
      float& result = image.depth[index];
      result = std::numeric_limits<float>::quiet_NaN();
      if (std::isnan(here.depth)) continue;
      CounterRandom random(seed, frame, index);
      const double lost = random.Uniform(), mixed = random.Uniform(), share = random.Uniform(), noise = random.Normal();
      const double incidence = std::acos(std::min(1.0, here.cos_incidence));
      if (incidence > options.dropout_begin) {
        const double range = options.dropout_end - options.dropout_begin;
        if (incidence >= options.dropout_end || lost * range < incidence - options.dropout_begin) continue;
      }
      double depth = here.depth;
      if (mixed < options.mixed_pixel_probability) {
        double other = depth;  // of the neighbour across the largest jump
        const auto look = [&](int c, int r) {
          if (!image.contains(c, r)) return;
          const double z = seen[image.index(c, r)].depth;
          if (std::abs(z - depth) > std::max(options.mixed_pixel_jump, std::abs(other - depth))) other = z;
        };
        const int r = static_cast<int>(row);
        look(column - 1, r), look(column + 1, r), look(column, r - 1), look(column, r + 1);
        depth += share * (other - depth);
      }
      const double distance = here.range / options.noise_distance;
      const double sigma = sensor.depth_noise / std::max(here.cos_incidence, 0.05) * distance * distance;
      depth += sigma * noise * (here.depth / here.range);
      if (options.depth_quantum > 0.0) depth = std::round(depth / options.depth_quantum) * options.depth_quantum;
      if (depth >= sensor.min_depth && depth <= sensor.max_depth) result = static_cast<float>(depth);
    }
  });
  return image;
}

StationGeometry MakeStation(double distance, double elevation, double look_at_height, int columns, int rows,
                            double field, double depth_noise) {
  if (!(distance > 0.0) || !(field > 0.0) || columns <= 0 || rows <= 0 || !(std::abs(elevation) < 1.5708)) {
    throw std::invalid_argument(
        "MakeStation: distance, field and image must be positive, the elevation below 90 degrees");
  }
  StationGeometry station;
  SensorModel& sensor = station.sensor;
  sensor.columns = columns;
  sensor.rows = rows;
  sensor.focal_u = sensor.focal_v = columns * distance / field;
  sensor.center_u = 0.5 * (columns - 1);
  sensor.center_v = 0.5 * (rows - 1);
  sensor.min_depth = 0.3 * distance;
  sensor.max_depth = 2.9 * distance;
  sensor.depth_noise = depth_noise;
  station.X_WT = Pose::Translation({0.0, 0.0, 0.1});
  // z of S looks along +y and down, x of S along +x.
  Eigen::Matrix3d R_WS;
  const double c = std::cos(elevation), s = std::sin(elevation);
  R_WS << 1, 0, 0,  //
      0, -s, c,     //
      0, -c, -s;
  const Eigen::Vector3d target = station.X_WT * Eigen::Vector3d(0.0, 0.0, look_at_height);
  station.X_WS = Pose(R_WS, target - distance * R_WS.col(2));
  return station;
}

}  // namespace geond::sim
