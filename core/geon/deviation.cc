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

// Seen from one side, a round shape's width is told by its curvature alone, on which the errors of normals at the limb weigh
// more than their scatter says: by about this factor (one view of noisy ellipsoids and cylinders).
constexpr double kOneSided = 4.0;
// And of any shape seen from one side the scatter says too little: nothing opposes what plane fits do at creases and limbs.
// So much more, and this share of the size besides (fit_noise_validation: the errors of single views with normals of plane
// fits).
constexpr double kOneView = 1.5, kOneViewShare = 0.025;

}  // namespace

std::vector<double> Deviations(const GeonState& state, const FitData& data, double lambda, const Ends& ends) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const int count = ParameterCount(state.type);
  const LanePoints points = data.all.Part(0, data.all.size);   // without the empty places
  const double gamma = state.gamma(), t1 = SumMisfit(state, points).distance / points.size;
  // With errors normally distributed the expected curvature of the mean of |e| is that of weights 1 / max(|e|, 1.5 t1).
  MisfitDerivatives d;
  DifferentiateMisfit(state, points, 2.0 * lambda * gamma, std::max(1.5 * t1, 1e-12), d);
  const Eigen::MatrixXd curvature = d.hessian.topLeftCorner(count, count);
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  int stretches = 0;
  for (int begin = 0; begin < points.size; begin += kStretch, ++stretches) {
    MisfitDerivatives part;
    DifferentiateMisfit(state, points.Part(begin, std::min(kStretch, points.size - begin)), 0.0, std::max(0.1 * t1, 1e-12),
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
  const auto put = [&](int to, int from, double limit, double factor = 1.0, double room = 0.0) {
    const double value = std::hypot(factor * std::sqrt(std::max(0.0, variance[from])), room);
    deviation[to] = unit[from] > 0.0 && value < limit ? value : kUnknown;
  };
  const GeonType base = BaseType(state.type);
  const bool one_view = !data.view.isZero();
  for (int k = 0; k < 3; ++k) {
    const bool round = base == GeonType::kEllipsoid || (base == GeonType::kCylinder && k < 2);
    const double systematic = one_view ? kOneViewShare * state.size[k] : 0.0;
    double factor = one_view ? kOneView : 1.0, variance_of_ends = systematic * systematic;
    bool told = true;
    for (int side = 0; side < 2; ++side) {
      if (ends.state[k][side] == EndState::kSeen) continue;
      if (round) {
        factor = std::max(factor, kOneSided);
      } else if (ends.state[k][side] == EndState::kHidden) {
        told = false;
      } else {   // anywhere between the points and the empty places
        const double room = std::max(0.0, state.size[k] + ends.gap[k][side] - ends.reach[k][side]);
        variance_of_ends += room * room / 48.0;   // of half the room
      }
    }
    const double room = std::sqrt(variance_of_ends);
    put(k, 3 + k, told ? 0.25 : 0.0, factor, room);
    put(3 + k, k, 0.5);
    put(6 + k, 6 + k, told ? 0.5 * state.size[k] : 0.0, factor, room);
  }
  if (IsTapered(state.type)) for (int k = 0; k < 2; ++k) put(9 + k, 9 + k, 0.5);
  if (IsCurved(state.type)) put(11, 9, std::max(state.deformation[0], 0.3 / state.size.z()));
  return deviation;
}

}  // namespace geond
