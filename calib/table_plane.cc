// SPDX-License-Identifier: Apache-2.0
#include "calib/table_plane.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace geond::calib {
namespace {

constexpr int kTrials = 160;
constexpr std::size_t kCounted = 1500;    // points a trial is judged on
constexpr double kMinSpread = 0.010;      // m, standard deviation across the table's narrow direction for a tilt

bool Allowed(const TablePlane& plane, const TablePlaneOptions& options) {
  return plane.Tilt() <= options.max_tilt && std::abs(plane.offset) <= options.max_height;
}

std::size_t CountWithin(const TablePlane& plane, const std::vector<Eigen::Vector3d>& points, double tolerance) {
  return std::count_if(points.begin(), points.end(),
                       [&](const Eigen::Vector3d& p) { return std::abs(plane.Height(p)) <= tolerance; });
}

TablePlane Consensus(const std::vector<Eigen::Vector3d>& points, double tolerance, const TablePlaneOptions& options) {
  std::vector<Eigen::Vector3d> counted;
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kCounted);
  for (std::size_t i = 0; i < points.size(); i += stride) counted.push_back(points[i]);

  TablePlane best;
  std::size_t best_count = CountWithin(best, counted, tolerance);
  std::uint64_t state = 0x9e3779b97f4a7c15ull;
  const auto draw = [&] {  // xorshift: the same three points on every machine
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return static_cast<std::size_t>(state % counted.size());
  };
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector3d a = counted[draw()], b = counted[draw()], c = counted[draw()];
    Eigen::Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 1e-6) continue;  // an area below a square millimetre says nothing
    normal.normalize();
    if (normal.z() < 0) normal = -normal;
    TablePlane plane;
    plane.normal_T = normal;
    plane.offset = normal.dot(a);
    if (!Allowed(plane, options)) continue;
    const std::size_t count = CountWithin(plane, counted, tolerance);
    if (count > best_count) best = plane, best_count = count;
  }
  return best;
}

// Least squares on the points within `tolerance` of `plane`.
TablePlane Refit(const TablePlane& plane, const std::vector<Eigen::Vector3d>& points, double tolerance) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  int n = 0;
  for (const auto& p : points) {
    if (std::abs(plane.Height(p)) <= tolerance) mean += p, ++n;
  }
  TablePlane fit = plane;
  fit.returns = n;
  if (n == 0) return fit;
  mean /= n;
  for (const auto& p : points) {
    if (std::abs(plane.Height(p)) <= tolerance) scatter += (p - mean) * (p - mean).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter / n);
  if (std::sqrt(std::max(0.0, eigen.eigenvalues()[1])) >= kMinSpread) {
    fit.normal_T = eigen.eigenvectors().col(0);
    if (fit.normal_T.z() < 0) fit.normal_T = -fit.normal_T;
  } else {
    fit.normal_T = Eigen::Vector3d::UnitZ();
  }
  fit.offset = fit.normal_T.dot(mean);
  fit.rms = std::sqrt(std::max(0.0, fit.normal_T.dot(scatter * fit.normal_T) / n));
  return fit;
}

}  // namespace

double TablePlane::Tilt() const { return std::acos(std::clamp(normal_T.z(), -1.0, 1.0)); }

TablePlane FitTablePlane(const std::vector<Eigen::Vector3d>& points_T, const TablePlaneOptions& options) {
  const double noise = options.noise > 0 ? options.noise : 0.0002;
  const double tolerance = 3.0 * noise;
  std::vector<Eigen::Vector3d> points;
  for (const auto& p : points_T) {
    const double allowed = options.max_height + std::tan(options.max_tilt) * p.head<2>().norm();
    if (p.allFinite() && std::abs(p.z()) <= allowed) points.push_back(p);
  }
  const std::size_t asked = points.size();
  if (asked < static_cast<std::size_t>(options.min_returns)) return {};

  TablePlane plane = Consensus(points, tolerance, options);
  // A flat plate on the table may hold more returns than the table: the lowest well-filled plane is the table.
  for (int lower = 0; lower < 3; ++lower) {
    std::vector<Eigen::Vector3d> below;
    for (const auto& p : points) {
      if (plane.Height(p) < -2.0 * tolerance) below.push_back(p);
    }
    const double needed = std::max<double>(options.min_returns, options.lower_share * static_cast<double>(asked));
    if (static_cast<double>(below.size()) < needed) break;
    const TablePlane candidate = Consensus(below, tolerance, options);
    if (static_cast<double>(CountWithin(candidate, below, tolerance)) < needed) break;
    plane = candidate;
  }
  for (int round = 0; round < 3; ++round) plane = Refit(plane, points, tolerance);
  if (plane.returns < options.min_returns || !Allowed(plane, options)) return {};
  plane.refined = true;
  return plane;
}

}  // namespace geond::calib
