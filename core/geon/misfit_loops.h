// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace geond::lanes {

// What the inner loops of the objective take and give: plain numbers, so that the files compiled for one instruction set
// alone include nothing that other files share.

inline constexpr int kLanes = 8;
inline constexpr int kMostParameters = 11;

struct PlainPoints {
  const double* point[3];
  const double* normal[3];
  const double* weight;
  const double* empty;   // 1 where no surface is: counts if the geon covers it, by its depth
  int padded;            // a multiple of kLanes
};

struct PlainState {
  double rotation[3][3];   // of X_TG, row by row
  double center[3], size[3], deformation[2];
};

struct PlainSums {
  double weight, distance, smooth, normal, covered;
};

struct PlainDerivatives {
  PlainSums sums;
  double hessian[kMostParameters * (kMostParameters + 1) / 2];   // lower triangle, row by row
  double distance_gradient[kMostParameters], normal_gradient[kMostParameters];
};

// For the seven types, in their order.
struct Loops {
  PlainSums (*sum[7])(const PlainState& state, const PlainPoints& points, double floor);
  void (*differentiate[7])(const PlainState& state, const PlainPoints& points, double normal_weight, double floor,
                           PlainDerivatives& out);
};

extern const Loops kBaselineLoops, kAvx2Loops, kAvx512Loops;

}  // namespace geond::lanes
