// SPDX-License-Identifier: Apache-2.0
#include "core/geon/misfit.h"

#include <algorithm>

#include "core/geon/misfit_loops.h"

namespace geond {
namespace {

// The inner loops are compiled once for each instruction set; which ones run is asked of the processor.
const lanes::Loops& BestLoops() {
  static const lanes::Loops& best = []() -> const lanes::Loops& {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) return lanes::kAvx512Loops;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return lanes::kAvx2Loops;
#endif
    return lanes::kBaselineLoops;
  }();
  return best;
}

lanes::PlainPoints Plain(const LanePoints& points) {
  const auto& p = points.point;
  const auto& n = points.normal;
  return {{p[0].data(), p[1].data(), p[2].data()},
          {n[0].data(), n[1].data(), n[2].data()},
          points.weight.data(),
          points.empty.data(),
          points.padded()};
}

lanes::PlainState Plain(const GeonState& state) {
  lanes::PlainState plain;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) plain.rotation[i][j] = state.rotation(i, j);
    plain.center[i] = state.center[i];
    plain.size[i] = state.size[i];
  }
  plain.deformation[0] = state.deformation[0];
  plain.deformation[1] = state.deformation[1];
  return plain;
}

std::size_t PlaceOf(GeonType type) { return static_cast<std::size_t>(type) - 1; }

MisfitSums SumsOf(const lanes::PlainSums& s) { return {s.weight, s.distance, s.smooth, s.normal, s.covered}; }

std::size_t WholeLanes(int count) {
  return (static_cast<std::size_t>(count) + lanes::kLanes - 1) / lanes::kLanes * lanes::kLanes;
}

}  // namespace

int ParameterCount(GeonType type) { return IsTapered(type) ? 11 : IsCurved(type) ? 10 : 9; }

LanePoints::LanePoints(int count) : size(count) {
  const std::size_t whole = WholeLanes(count);
  for (auto& list : point) list.assign(whole, 0.0);
  for (auto& list : normal) list.assign(whole, 0.0);
  weight.assign(whole, 0.0);
  std::fill_n(weight.begin(), count, 1.0);
  empty.assign(whole, 0.0);
}

LanePoints LanePoints::Part(int begin, int count) const {
  LanePoints part(count);
  for (int k = 0; k < 3; ++k) {
    std::copy_n(point[k].begin() + begin, count, part.point[k].begin());
    std::copy_n(normal[k].begin() + begin, count, part.normal[k].begin());
  }
  return part;
}

void LanePoints::AddEmpty(const std::vector<Eigen::Vector3d>& places, double total_weight) {
  if (places.empty()) return;
  const std::size_t begin = weight.size(), whole = begin + WholeLanes(static_cast<int>(places.size()));
  for (auto& list : point) list.resize(whole, 0.0);
  for (auto& list : normal) list.resize(whole, 0.0);
  weight.resize(whole, 0.0);
  empty.resize(whole, 1.0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (int k = 0; k < 3; ++k) point[k][begin + i] = places[i][k];
    weight[begin + i] = total_weight / static_cast<double>(places.size());
  }
}

void LanePoints::Set(int i, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  for (int k = 0; k < 3; ++k) {
    point[k][i] = p[k];
    normal[k][i] = n[k];
  }
}

GeonState StateOf(const Geon& geon) {
  GeonState state{geon.type, geon.X_TG.matrix(), geon.X_TG.translation(), geon.size, Eigen::Vector2d::Zero()};
  if (IsTapered(geon.type)) state.deformation = geon.taper;
  if (IsCurved(geon.type)) state.deformation[0] = geon.bend;
  return state;
}

Geon GeonOf(const GeonState& state) {
  Geon geon;
  geon.type = state.type;
  geon.X_TG = Pose(Eigen::Quaterniond(state.rotation), state.center);
  geon.size = state.size;
  if (IsTapered(state.type)) geon.taper = state.deformation;
  if (IsCurved(state.type)) geon.bend = state.deformation[0];
  return geon;
}

MisfitSums SumMisfit(const GeonState& state, const LanePoints& points, double floor) {
  return SumsOf(BestLoops().sum[PlaceOf(state.type)](Plain(state), Plain(points), floor));
}

void DifferentiateMisfit(const GeonState& state, const LanePoints& points, double normal_weight, double floor,
                         MisfitDerivatives& out) {
  lanes::PlainDerivatives plain;
  BestLoops().differentiate[PlaceOf(state.type)](Plain(state), Plain(points), normal_weight, floor, plain);
  out.sums = SumsOf(plain.sums);
  const int n = ParameterCount(state.type);
  int at = 0;
  for (int j = 0; j < n; ++j) {
    out.distance_gradient[j] = plain.distance_gradient[j];
    out.normal_gradient[j] = plain.normal_gradient[j];
    for (int k = 0; k <= j; ++k) out.hessian(j, k) = out.hessian(k, j) = plain.hessian[at++];
  }
}

}  // namespace geond
