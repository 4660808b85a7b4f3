// SPDX-License-Identifier: Apache-2.0
#include "core/geon/anneal_type.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/geon/shape.h"

namespace geond {

GeonState AnnealedState(GeonType type, std::span<const double> p) {
  GeonState s;
  s.type = type;
  s.size = {p[0], p[1], p[2]};
  s.center = {p[3], p[4], p[5]};
  s.rotation = (Eigen::AngleAxisd(p[8], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(p[7], Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(p[6], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  if (IsTapered(type)) s.deformation = {p[9], p[10]};
  if (IsCurved(type)) s.deformation[0] = p[9] * std::min(kMaxFold / s.size.x(), std::numbers::pi / s.size.z());
  return s;
}

std::vector<VfsrRange> AnnealRanges(GeonType type, const FitData& data) {
  // The unit is the diagonal: L = 1.
  std::vector<VfsrRange> ranges;
  const double greatest_z = IsCurved(type) ? 0.85 : 0.5;
  for (int k = 0; k < 3; ++k) ranges.push_back({0.01, k == 2 ? greatest_z : 0.5});
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < data.all.size; ++i) {
    mean += Eigen::Vector3d(data.all.point[0][i], data.all.point[1][i], data.all.point[2][i]) / data.all.size;
  }
  for (int k = 0; k < 3; ++k) ranges.push_back({mean[k] - 0.5, mean[k] + 0.5});
  for (int k = 0; k < 3; ++k) ranges.push_back({-std::numbers::pi, std::numbers::pi, true});
  if (IsTapered(type)) ranges.insert(ranges.end(), 2, {0.0, kMaxTaper});
  if (IsCurved(type)) ranges.push_back({0.0, 1.0});
  return ranges;
}

RefineResult AnnealType(GeonType type, const FitData& data, double lambda, std::uint64_t seed, const VfsrOptions& options,
                        std::stop_token stop) {
  const auto objective = [&](std::span<const double> p) {
    const GeonState s = AnnealedState(type, p);
    const MisfitSums sums = SumMisfit(s, data.all);
    return (sums.distance + lambda * s.gamma() * sums.normal + sums.covered) / sums.weight;
  };
  const VfsrResult annealed = Anneal(objective, AnnealRanges(type, data), seed, options, stop);
  RefineResult result;
  result.state = AnnealedState(type, annealed.parameters);
  const MisfitSums sums = SumMisfit(result.state, data.all);
  result.objective = annealed.value;
  result.t1 = sums.distance / sums.weight;
  result.t2 = sums.normal / sums.weight;
  result.evaluations = annealed.evaluations;
  result.converged = annealed.stop != VfsrStop::kEvaluations;
  return result;
}

}  // namespace geond
