// SPDX-License-Identifier: Apache-2.0
#include "core/geon/deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "core/geon/shape.h"

namespace geond {
namespace {

constexpr int kStretch = 8;
constexpr double kLeastFace = 0.008;   // share of the points that a face needs to be called seen

LanePoints Stretch(const LanePoints& points, int begin, int count) {
  LanePoints part(count);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      part.point[k][i] = points.point[k][begin + i];
      part.normal[k][i] = points.normal[k][begin + i];
    }
  }
  return part;
}

// Seen from one side, a round shape's width is told by its curvature alone, on which the errors of normals at the limb weigh
// more than their scatter says: by about this factor (one view of noisy ellipsoids and cylinders).
constexpr double kOneSided = 4.0;

// Whether the two faces across each axis of G have points.
std::array<bool, 3> FacesSeen(const GeonState& state, const LanePoints& points) {
  const Geon geon = GeonOf(state);
  std::array<std::array<int, 2>, 3> count{};
  for (int i = 0; i < points.size; ++i) {
    const Eigen::Vector3d p(points.point[0][i], points.point[1][i], points.point[2][i]);
    const Eigen::Vector3d m = GaugeGradient(geon, Undeform(geon, state.rotation.transpose() * (p - state.center))).normalized();
    for (int k = 0; k < 3; ++k) if (std::abs(m[k]) > 0.8) ++count[k][m[k] > 0.0];
  }
  std::array<bool, 3> seen{true, true, true};
  for (int k = 0; k < 3; ++k) {
    seen[k] = std::min(count[k][0], count[k][1]) >= std::max(2.0, kLeastFace * points.size);
  }
  return seen;
}

}  // namespace

std::vector<double> Deviations(const GeonState& state, const FitData& data, double lambda) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const int count = ParameterCount(state.type);
  const LanePoints& points = data.all;
  const double gamma = state.gamma(), t1 = SumMisfit(state, points).distance / points.size;
  // With errors normally distributed the expected curvature of the mean of |e| is that of weights 1 / max(|e|, 1.5 t1).
  MisfitDerivatives d;
  DifferentiateMisfit(state, points, 2.0 * lambda * gamma, std::max(1.5 * t1, 1e-12), d);
  const Eigen::MatrixXd curvature = d.hessian.topLeftCorner(count, count);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  int stretches = 0;
  for (int begin = 0; begin < points.size; begin += kStretch, ++stretches) {
    MisfitDerivatives part;
    DifferentiateMisfit(state, Stretch(points, begin, std::min(kStretch, points.size - begin)), 0.0, std::max(0.1 * t1, 1e-12),
                        part);
    const Eigen::VectorXd slope = part.distance_gradient.head(count) + 2.0 * lambda * gamma * part.normal_gradient.head(count);
    scatter += slope * slope.transpose();
  }
  scatter *= static_cast<double>(stretches) / std::max(1, stretches - count);

  // Inverse in units that make the diagonal 1; directions with next to no curvature are not determined.
  Eigen::VectorXd unit(count);
  for (int k = 0; k < count; ++k) unit[k] = curvature(k, k) > 0.0 ? 1.0 / std::sqrt(curvature(k, k)) : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * curvature * unit.asDiagonal());
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(1e-8);
  const Eigen::MatrixXd inverse = unit.asDiagonal() * eigen.eigenvectors() * values.cwiseInverse().asDiagonal() *
                                  eigen.eigenvectors().transpose() * unit.asDiagonal();
  const Eigen::VectorXd variance = (inverse * scatter * inverse).diagonal();

  std::vector<double> deviation(12, 0.0);
  const auto put = [&](int to, int from, double limit, double factor = 1.0) {
    const double value = factor * std::sqrt(std::max(0.0, variance[from]));
    deviation[to] = unit[from] > 0.0 && value < limit ? value : kUnknown;
  };
  const std::array<bool, 3> seen = FacesSeen(state, points);
  const GeonType base = BaseType(state.type);
  for (int k = 0; k < 3; ++k) {
    const bool round = base == GeonType::kEllipsoid || (base == GeonType::kCylinder && k < 2);
    const bool told = seen[k] || round;
    const double factor = seen[k] ? 1.0 : kOneSided;
    put(k, 3 + k, told ? 0.25 : 0.0, factor);
    put(3 + k, k, 0.5);
    put(6 + k, 6 + k, told ? 0.5 * state.size[k] : 0.0, factor);
  }
  if (IsTapered(state.type)) for (int k = 0; k < 2; ++k) put(9 + k, 9 + k, 0.5);
  if (IsCurved(state.type)) put(11, 9, std::max(state.deformation[0], 0.3 / state.size.z()));
  return deviation;
}

}  // namespace geond
