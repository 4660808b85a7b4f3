// SPDX-License-Identifier: Apache-2.0
#include "calib/path_check.h"

#include <cmath>
#include <map>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/base/printed.h"

namespace geond::calib {
namespace {

struct Departure {
  std::size_t placement, image;
  double angle;
  Eigen::Vector3d at_S, in_S, in_T;  // where one centre should be, and by how much it is not there, m
};

std::vector<Departure> Departures(const SensorModel& sensor, const StationFit& fit,
                                  const std::vector<SightedPlacement>& placements) {
  std::vector<Departure> all;
  for (std::size_t k = 0; k < placements.size(); ++k) {
    for (std::size_t i = 0; i < placements[k].sightings.size(); ++i) {
      const TargetSighting& sighting = placements[k].sightings[i];
      std::vector<Eigen::Vector3d> points_S;
      for (const auto& raw : sighting.sphere) points_S.push_back(CorrectedPoint(sensor, fit.sensor, raw));
      const Pose X_ST = fit.X_ST * Pose::Rotation(Eigen::Vector3d::UnitZ(), sighting.table_angle);
      const Eigen::Vector3d expected_S = X_ST * fit.centers_T[k];
      const Eigen::Vector3d off_S = FitSphere(points_S, expected_S, placements[k].radius).center - expected_S;
      all.push_back({k, i, sighting.table_angle, expected_S, off_S, Inverse(X_ST).Rotate(off_S)});
    }
  }
  return all;
}

double SquaresOf(const std::vector<Departure>& all) {
  double squares = 0.0;
  for (const auto& one : all) squares += one.in_S.squaredNorm();
  return squares;
}

struct Step {
  std::size_t placement = 0, image = 0;
  double length = 0.0;     // m
  double explained = 0.0;  // of the squares of that placement
  double squares = 0.0;
};

// The best split of one placement's images into before and after, each with a place of its own on the table.
Step BestStep(const std::vector<Departure>& all, std::size_t placement) {
  std::vector<Eigen::Vector3d> off;
  for (const auto& one : all) {
    if (one.placement == placement) off.push_back(one.in_T);
  }
  Step best;
  best.placement = placement;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& d : off) sum += d, best.squares += d.squaredNorm();
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < off.size(); ++i) {
    before += off[i - 1];
    const double n = static_cast<double>(i), m = static_cast<double>(off.size() - i);
    const Eigen::Vector3d a = before / n, b = (sum - before) / m;
    const double explained = (n * a.squaredNorm() + m * b.squaredNorm()) / std::max(1e-18, best.squares);
    if (explained > best.explained) best.explained = explained, best.image = i, best.length = (b - a).norm();
  }
  return best;
}

// Share of the squares that one small motion of the table at each table angle explains for all placements: then the table
// moves, not the target. Six numbers for three placements (nine numbers) explain two thirds of pure chance.
double CommonShare(const std::vector<Departure>& all) {
  std::map<long, std::vector<const Departure*>> by_angle;
  for (const auto& one : all) by_angle[std::lround(one.angle * 1e3)].push_back(&one);
  double left = 0.0, squares = 0.0;
  for (const auto& [angle, group] : by_angle) {
    if (group.size() < 3) continue;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const auto* one : group) middle += one->at_S / static_cast<double>(group.size());
    Eigen::Matrix<double, 6, 6> A = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    const auto rows = [&](const Departure& one) {
      const Eigen::Vector3d arm = one.at_S - middle;
      Eigen::Matrix<double, 3, 6> J;  // of rotation x arm + translation
      J << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(), -arm.x(), 0, 0, 0, 1;
      return J;
    };
    for (const auto* one : group) A += rows(*one).transpose() * rows(*one), g += rows(*one).transpose() * one->in_S;
    const Eigen::Matrix<double, 6, 1> motion = A.ldlt().solve(g);
    for (const auto* one : group) {
      left += (one->in_S - rows(*one) * motion).squaredNorm();
      squares += one->in_S.squaredNorm();
    }
  }
  return squares > 0 ? 1.0 - left / squares : 0.0;
}

}  // namespace

PathCheck CheckPaths(const SensorModel& sensor, const StationFit& fit, const std::vector<SightedPlacement>& placements) {
  const std::vector<Departure> all = Departures(sensor, fit, placements);
  PathCheck check;
  const double squares = SquaresOf(all);
  check.rms = std::sqrt(squares / std::max<double>(1.0, static_cast<double>(all.size())));
  Step worst;
  for (std::size_t k = 0; k < placements.size(); ++k) {
    const Step step = BestStep(all, k);
    if (step.squares * step.explained > worst.squares * worst.explained) worst = step;
  }
  const double common = CommonShare(all);
  if (worst.squares > 0.5 * squares && worst.explained > 0.6) {
    check.reason = Printed("the target in placement %zu moved by about %.2f mm between images %zu and %zu: fasten it (wax, "
                           "putty) and take that placement again",
                           worst.placement + 1, worst.length * 1e3, worst.image, worst.image + 1);
  } else if (common > 0.85) {
    check.reason = Printed("the target leaves its circle by %.2f mm rms in the same way in every placement: the axis is bent or "
                           "its bearing is loose, or the table's angles are read wrong", check.rms * 1e3);
  } else {
    check.reason = Printed("the target leaves its circle by %.2f mm rms without a pattern: it rocks, or the sensor moved; "
                           "fasten both and calibrate again", check.rms * 1e3);
  }
  return check;
}

}  // namespace geond::calib
