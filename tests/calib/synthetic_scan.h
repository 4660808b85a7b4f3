// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/range/range_view.h"
#include "core/range/scan_folder.h"

namespace geond::calib {

// A scene of spheres, upright boxes and upright cylinders on the table z = 0, met by rays in closed form. In T, m.
struct SyntheticScene {
  struct Sphere { Eigen::Vector3d center; double radius; };
  struct Box { Eigen::Vector3d low, high; };
  struct Cylinder { Eigen::Vector2d center; double radius, low, high; };
  std::vector<Sphere> spheres;
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;
  bool table = true;

  // Distance along the unit ray to the first surface; infinite if there is none.
  double Cast(const Eigen::Vector3d& o, const Eigen::Vector3d& d) const {
    double best = std::numeric_limits<double>::infinity();
    const auto take = [&](double t) {
      if (t > 1e-9 && t < best) best = t;
    };
    if (table && d.z() < 0) take(-o.z() / d.z());
    for (const auto& s : spheres) {
      const Eigen::Vector3d m = o - s.center;
      const double b = m.dot(d), disc = b * b - m.squaredNorm() + s.radius * s.radius;
      if (disc > 0) take(-b - std::sqrt(disc));
    }
    for (const auto& box : boxes) {
      double enter = 0, leave = best;
      for (int k = 0; k < 3; ++k) {
        const double t0 = (box.low[k] - o[k]) / d[k], t1 = (box.high[k] - o[k]) / d[k];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
      }
      if (enter < leave) take(enter);
    }
    for (const auto& c : cylinders) {
      const Eigen::Vector2d m = o.head<2>() - c.center, e = d.head<2>();
      const double a = e.squaredNorm(), b = m.dot(e), disc = b * b - a * (m.squaredNorm() - c.radius * c.radius);
      if (disc > 0) {
        const double t = (-b - std::sqrt(disc)) / a, z = o.z() + t * d.z();
        if (z > c.low && z < c.high) take(t);
      }
      const double t = (c.high - o.z()) / d.z();
      if ((m + t * e).norm() < c.radius) take(t);
    }
    return best;
  }
};

// Normal deviates that are the same everywhere.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : generator_(seed) {}
  double Uniform() { return static_cast<double>(generator_() >> 11) * 0x1p-53; }
  double Normal() {
    return std::sqrt(-2.0 * std::log(1.0 - Uniform())) * std::cos(2.0 * M_PI * Uniform());
  }
  Eigen::Vector3d Vector() {
    const double x = Normal(), y = Normal(), z = Normal();
    return {x, y, z};
  }

 private:
  std::mt19937_64 generator_;
};

// A sensor 450 mm from the axis, 30 degrees up, looking at a point 30 mm over the table.
inline StationGeometry SyntheticStation(int pixels = 120, double field = 0.20) {
  StationGeometry station;
  SensorModel& sensor = station.sensor;
  sensor.columns = sensor.rows = pixels;
  sensor.focal_u = sensor.focal_v = pixels * 0.45 / field;
  sensor.center_u = sensor.center_v = 0.5 * (pixels - 1);
  sensor.depth_noise = 0.0002;
  const double up = M_PI / 6;
  const Eigen::Vector3d at(0.45 * std::cos(up), 0.0, 0.45 * std::sin(up) + 0.03);
  Eigen::Matrix3d R_WS;
  R_WS.col(2) = Eigen::Vector3d(-std::cos(up), 0.0, -std::sin(up));
  R_WS.col(0) = Eigen::Vector3d(0, 1, 0);
  R_WS.col(1) = R_WS.col(2).cross(R_WS.col(0));
  station.X_WS = Pose(R_WS, at);
  return station;
}

inline RangeImage TakeImage(const SyntheticScene& scene, const SensorModel& sensor, const Pose& X_TS, double noise,
                            Noise& random) {
  RangeImage image{sensor.columns, sensor.rows, {}};
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.columns; ++u) {
      const Eigen::Vector3d ray_S = RayDirection(sensor, u, v);
      const double t = scene.Cast(X_TS.translation(), X_TS.Rotate(ray_S)) + noise * random.Normal();
      image.depth.push_back(std::isfinite(t) ? static_cast<float>(t * ray_S.z()) : std::nanf(""));
    }
  }
  return image;
}

// A scan of evenly turned views with true poses as the measured ones.
inline RecordedScan SyntheticScan(const SyntheticScene& scene, int views, double noise, std::uint64_t seed = 1,
                                  StationGeometry station = SyntheticStation()) {
  RecordedScan scan;
  scan.station = station;
  scan.has_table = scene.table;
  Noise random(seed);
  for (int k = 0; k < views; ++k) {
    RecordedScan::View view;
    view.exposure.table_angle = 2.0 * M_PI * k / views;
    view.sensor = station.sensor;
    view.X_TS_measured = SensorInTurntable(station, view.exposure.table_angle);
    view.exposure.image = TakeImage(scene, view.sensor, view.X_TS_measured, noise, random);
    scan.views.push_back(std::move(view));
  }
  return scan;
}

// Box and sphere side by side: shows every motion.
inline SyntheticScene BoxAndSphere() {
  SyntheticScene scene;
  scene.boxes.push_back({{-0.035, -0.020, 0.0}, {0.015, 0.025, 0.040}});
  scene.spheres.push_back({{0.025, 0.005, 0.030}, 0.024});
  return scene;
}

}  // namespace geond::calib
