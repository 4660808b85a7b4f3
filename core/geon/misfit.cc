// SPDX-License-Identifier: Apache-2.0
#include "core/geon/misfit.h"

#include <algorithm>

#include "core/geon/misfit_kernel.h"

namespace geond {
namespace {

using namespace lanes;

// The kernel once for each instruction set; which one runs is asked of the processor.
#define GEOND_FOR_EACH_TYPE(CALL)                                                  \
  switch (state.type) {                                                            \
    case GeonType::kEllipsoid: CALL(GeonType::kEllipsoid); break;                  \
    case GeonType::kCylinder: CALL(GeonType::kCylinder); break;                    \
    case GeonType::kCuboid: CALL(GeonType::kCuboid); break;                        \
    case GeonType::kTaperedCylinder: CALL(GeonType::kTaperedCylinder); break;      \
    case GeonType::kTaperedCuboid: CALL(GeonType::kTaperedCuboid); break;          \
    case GeonType::kCurvedCylinder: CALL(GeonType::kCurvedCylinder); break;        \
    case GeonType::kCurvedCuboid: CALL(GeonType::kCurvedCuboid); break;            \
  }

#define GEOND_KERNELS(SUFFIX, TARGET)                                                                               \
  TARGET MisfitSums Sum##SUFFIX(const GeonState& state, const LanePoints& points, double floor) {                   \
    MisfitSums sums;                                                                                                \
    GEOND_FOR_EACH_TYPE(GEOND_SUM)                                                                                  \
    return sums;                                                                                                    \
  }                                                                                                                 \
  TARGET void Points##SUFFIX(const GeonState& state, const LanePoints& points, double* e, double* normal) {         \
    GEOND_FOR_EACH_TYPE(GEOND_POINTS)                                                                               \
  }                                                                                                                 \
  TARGET void Differentiate##SUFFIX(const GeonState& state, const LanePoints& points, double normal_weight,         \
                                    double floor, MisfitDerivatives& out) {                                         \
    GEOND_FOR_EACH_TYPE(GEOND_DIFFERENTIATE)                                                                        \
  }
#define GEOND_SUM(TYPE) sums = SumBlocks<TYPE>(state, points, floor)
#define GEOND_POINTS(TYPE) PointBlocks<TYPE>(state, points, e, normal)
#define GEOND_DIFFERENTIATE(TYPE) DifferentiateBlocks<TYPE>(state, points, normal_weight, floor, out)

GEOND_KERNELS(Baseline, )
#if defined(__x86_64__)
GEOND_KERNELS(Avx2, __attribute__((target("avx2"))))
GEOND_KERNELS(Avx512, __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512"))))
#endif

struct Kernels {
  MisfitSums (*sum)(const GeonState&, const LanePoints&, double) = SumBaseline;
  void (*points)(const GeonState&, const LanePoints&, double*, double*) = PointsBaseline;
  void (*differentiate)(const GeonState&, const LanePoints&, double, double, MisfitDerivatives&) = DifferentiateBaseline;
};

const Kernels& BestKernels() {
  static const Kernels best = [] {
    Kernels kernels;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
      kernels = {SumAvx512, PointsAvx512, DifferentiateAvx512};
    } else if (__builtin_cpu_supports("avx2")) {
      kernels = {SumAvx2, PointsAvx2, DifferentiateAvx2};
    }
#endif
    return kernels;
  }();
  return best;
}

}  // namespace

int ParameterCount(GeonType type) { return CountOf(type); }

LanePoints::LanePoints(int count) : size(count) {
  const std::size_t whole = (static_cast<std::size_t>(count) + kLanes - 1) / kLanes * kLanes;
  for (auto& list : point) list.assign(whole, 0.0);
  for (auto& list : normal) list.assign(whole, 0.0);
  weight.assign(whole, 0.0);
  std::fill_n(weight.begin(), count, 1.0);
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
  return BestKernels().sum(state, points, floor);
}

void DifferentiateMisfit(const GeonState& state, const LanePoints& points, double normal_weight, double floor,
                         MisfitDerivatives& out) {
  BestKernels().differentiate(state, points, normal_weight, floor, out);
}

void PointMisfits(const GeonState& state, const LanePoints& points, double* e, double* normal) {
  BestKernels().points(state, points, e, normal);
}

}  // namespace geond
