// SPDX-License-Identifier: Apache-2.0
#include "calib/target_sphere.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "calib/table_plane.h"

namespace geond::calib {
namespace {

constexpr int kTrials = 400;
constexpr std::size_t kCounted = 1200;
constexpr std::size_t kMostReturns = 400;  // kept of sphere and of table
constexpr std::size_t kFewestReturns = 60;
constexpr double kNear = 0.0012;           // m from the sphere for a return to be of it, at first
constexpr double kSizeTolerance = 0.1;
constexpr double kLeastCosine = 0.4;       // of incidence

struct Located {
  RawReturn raw;
  Eigen::Vector3d p_S;
};

std::vector<RawReturn> Thinned(const std::vector<Located>& all) {
  std::vector<RawReturn> some;
  const std::size_t take = std::min(kMostReturns, all.size());
  for (std::size_t k = 0; k < take; ++k) some.push_back(all[k * all.size() / take].raw);
  return some;
}

// Centre of a sphere of this radius through three points, behind them as seen from the origin.
std::optional<Eigen::Vector3d> CenterBehind(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                            double radius) {
  const Eigen::Vector3d u = b - a, v = c - a, w = u.cross(v);
  const double area = w.squaredNorm();
  if (area < 1e-14) return std::nullopt;
  const Eigen::Vector3d to_circle = (v.squaredNorm() * w.cross(u) + u.squaredNorm() * v.cross(w)) / (2.0 * area);
  const double height = radius * radius - to_circle.squaredNorm();
  if (height < 0.0) return std::nullopt;
  Eigen::Vector3d up = w / std::sqrt(area);
  if (up.dot(a) < 0) up = -up;
  return a + to_circle + std::sqrt(height) * up;
}

}  // namespace

SphereFit FitSphere(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& start, double radius) {
  SphereFit fit;
  fit.center = start;
  fit.radius = radius;
  const bool free = !(radius > 0.0);
  if (free) {
    for (const auto& p : points) fit.radius += (p - start).norm() / static_cast<double>(points.size());
  }
  for (int round = 0; round < 30; ++round) {
    std::vector<double> sizes;
    for (const auto& p : points) sizes.push_back(std::abs((p - fit.center).norm() - fit.radius));
    auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const double reach = 4.0 * std::max(1e-6, 1.4826 * *middle);
    Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
    Eigen::Vector4d g = Eigen::Vector4d::Zero();
    double squares = 0.0, weights = 0.0;
    for (const auto& p : points) {
      const Eigen::Vector3d d = p - fit.center;
      const double r = d.norm() - fit.radius, x = r / reach;
      if (std::abs(x) >= 1.0) continue;
      const double w = (1 - x * x) * (1 - x * x);
      Eigen::Vector4d j;
      j << -d.normalized(), free ? -1.0 : 0.0;
      A += w * j * j.transpose();
      g += w * j * r;
      squares += w * r * r;
      weights += w;
    }
    if (!free) A(3, 3) = 1.0;
    fit.rms = std::sqrt(squares / std::max(1.0, weights));
    const Eigen::Vector4d step = A.ldlt().solve(-g);
    if (!step.allFinite()) break;
    fit.center += step.head<3>();
    if (free) fit.radius += step[3];
    if (step.norm() < 1e-9) break;
  }
  return fit;
}

std::optional<TargetSighting> FindTarget(const Exposure& exposure, const StationGeometry& station, double radius) {
  const Pose X_TS = SensorInTurntable(station, exposure.table_angle);
  std::vector<Located> returns;
  std::vector<Eigen::Vector3d> points_T;
  for (int row = 0; row < exposure.image.rows; ++row) {
    for (int column = 0; column < exposure.image.columns; ++column) {
      const double depth = exposure.image.at(column, row);
      if (!std::isfinite(depth) || depth > station.sensor.max_depth || depth < station.sensor.min_depth) continue;
      Located at{{static_cast<double>(column), static_cast<double>(row), depth},
                 Unproject(station.sensor, column, row, depth)};
      const Eigen::Vector3d p_T = X_TS * at.p_S;
      if (p_T.head<2>().norm() > station.object_radius) continue;
      returns.push_back(at);
      points_T.push_back(p_T);
    }
  }
  TablePlaneOptions wide;
  wide.max_height = 0.020;
  wide.max_tilt = 0.09;
  wide.noise = std::max(0.0002, station.sensor.depth_noise);
  const TablePlane table = FitTablePlane(points_T, wide);
  std::vector<Located> above, on;
  for (std::size_t i = 0; i < returns.size(); ++i) {
    const double height = table.Height(points_T[i]);
    if (height > std::max(0.003, 4.0 * table.rms)) above.push_back(returns[i]);
    else if (table.refined && std::abs(height) < 3.0 * std::max(1e-4, table.rms)) on.push_back(returns[i]);
  }
  if (above.size() < kFewestReturns) return std::nullopt;

  std::vector<Located> counted;
  const std::size_t stride = std::max<std::size_t>(1, above.size() / kCounted);
  for (std::size_t i = 0; i < above.size(); i += stride) counted.push_back(above[i]);
  const auto within = [&](const Eigen::Vector3d& center, const Eigen::Vector3d& p) {
    return std::abs((p - center).norm() - radius) < kNear;
  };
  std::uint64_t state = 0x2545f4914f6cdd1dull;
  const auto draw = [&] {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return counted[state % counted.size()].p_S;
  };
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  std::ptrdiff_t most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto a = draw(), b = draw(), c = draw();
    const auto center = CenterBehind(a, b, c, radius);
    if (!center) continue;
    const auto count = std::count_if(counted.begin(), counted.end(), [&](const Located& at) {
      return within(*center, at.p_S);
    });
    if (count > most) most = count, best = *center;
  }
  const auto on_sphere = [&](const Eigen::Vector3d& center) {
    std::vector<Located> found;
    for (const auto& at : above) {
      // How squarely the sphere is met is taken from the ray alone: by the return's own place, noise would choose outer ones.
      const Eigen::Vector3d ray = RayDirection(station.sensor, at.raw.column, at.raw.row), arm = center - at.p_S;
      const double off = (arm - ray * ray.dot(arm)).norm() / radius;
      if (within(center, at.p_S) && off < std::sqrt(1.0 - kLeastCosine * kLeastCosine)) found.push_back(at);
    }
    return found;
  };
  TargetSighting sighting;
  std::vector<Eigen::Vector3d> points;
  sighting.table_angle = exposure.table_angle;
  sighting.center_S = best;
  std::vector<Located> found;
  for (int round = 0; round < 3; ++round) {
    found = on_sphere(sighting.center_S);
    if (found.size() < kFewestReturns) return std::nullopt;
    points.clear();
    for (const auto& at : found) points.push_back(at.p_S);
    const SphereFit fit = FitSphere(points, sighting.center_S, radius);
    sighting.center_S = fit.center;
    sighting.rms = fit.rms;
  }
  // A cap fits spheres of other sizes within a millimetre: the size that fits best must be near the one asked for.
  if (std::abs(FitSphere(points, sighting.center_S, 0.0).radius / radius - 1.0) > kSizeTolerance) return std::nullopt;
  sighting.sphere = Thinned(found);
  sighting.table = Thinned(on);
  return sighting;
}

}  // namespace geond::calib
