// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "core/geon/geon.h"

namespace geond {

// The objective as the optimisers need it: over many points at once in vector lanes, with derivatives, allocation-free.
// The same bits on every processor with fused multiplication and addition (x86 since 2013).

inline constexpr int kMaxParameters = 11;
// rotation 3 (X_TG turned by exp(w) on the right), position 3 (along G's axes), size 3, then taper 2 or bend 1.
int ParameterCount(GeonType type);

// Points and unit normals side by side, padded to whole lanes with weight 0; behind them the empty places, if any.
struct LanePoints {
  int size = 0;                       // points, without the padding and the empty places
  std::array<std::vector<double>, 3> point, normal;
  std::vector<double> weight;         // of each point in the sums, 1 unless changed
  std::vector<double> empty;          // 1 for an empty place, else 0

  LanePoints() = default;
  explicit LanePoints(int count);     // room for `count`, to be filled by Set
  void Set(int i, const Eigen::Vector3d& p, const Eigen::Vector3d& n);
  // Places where no surface is: a geon that covers one is the worse for the depth. Their weights sum up to `total_weight`.
  void AddEmpty(const std::vector<Eigen::Vector3d>& places, double total_weight);
  // `count` of the points from `begin` on, with weight 1.
  LanePoints Part(int begin, int count) const;
  int padded() const { return static_cast<int>(weight.size()); }
};

// A geon as the kernel takes it.
struct GeonState {
  GeonType type = GeonType::kEllipsoid;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   // of X_TG
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
  Eigen::Vector2d deformation = Eigen::Vector2d::Zero();    // Kx, Ky or bend, 0

  double gamma() const { return size.sum() / 3.0; }
};
GeonState StateOf(const Geon& geon);
Geon GeonOf(const GeonState& state);

using ParameterVector = Eigen::Matrix<double, kMaxParameters, 1>;
using ParameterMatrix = Eigen::Matrix<double, kMaxParameters, kMaxParameters>;

// Weighted sums over the points.
struct MisfitSums {
  double weight = 0.0;
  double distance = 0.0;     // of |e|
  double smooth = 0.0;       // of |e| where above `floor`, else (e^2 / floor + floor) / 2: the same with a slope at 0;
                             // and of the depths of empty places, likewise but without the constant
  double normal = 0.0;       // of |n_d - n_m|^2
  double covered = 0.0;      // of the depths of empty places
};
MisfitSums SumMisfit(const GeonState& state, const LanePoints& points, double floor = 0.0);

// ... and what Gauss-Newton needs of them: with J_e, J_n the derivatives of e and of n_m - n_d seen in T,
// hessian = sum J_e' J_e / max(|e|, floor) + normal_weight sum J_n' J_n,
// distance_gradient = sum J_e' e / max(|e|, floor), normal_gradient = sum J_n' (n_m - n_d).
struct MisfitDerivatives {
  MisfitSums sums;
  ParameterMatrix hessian;
  ParameterVector distance_gradient, normal_gradient;
};
// distance_gradient is that of the sum `smooth`, normal_gradient half that of `normal`.
void DifferentiateMisfit(const GeonState& state, const LanePoints& points, double normal_weight, double floor,
                         MisfitDerivatives& out);

}  // namespace geond
