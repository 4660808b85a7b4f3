// SPDX-License-Identifier: Apache-2.0
#include "core/charge/potential.h"

#include "core/charge/panels.h"
#include "core/charge/potential_formula.h"

namespace geond {

double TrianglePotential(const Eigen::Vector3d& r, const Eigen::Vector3d& v1, const Eigen::Vector3d& v2,
                         const Eigen::Vector3d& v3) {
  const charge::TriangleFrame frame = charge::MakeTriangleFrame(v1, v2, v3);
  if (!(frame.twice_area > 0.0)) return 0.0;
  return charge::TrianglePotentialFormula(frame, r.x(), r.y(), r.z());
}

}  // namespace geond
