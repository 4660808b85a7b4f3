// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/command.h"

#include <stdexcept>

namespace geond::daemon {

double MetersPerUnit(const std::string& unit) {
  if (unit == "mm") return 0.001;
  if (unit == "m") return 1.0;
  if (unit == "cm") return 0.01;
  if (unit == "in") return 0.0254;
  throw std::invalid_argument("no such unit: '" + unit + "'; there are mm, m, cm, in");
}

Json PoseJson(const Pose& pose) {
  Eigen::Quaterniond q = pose.rotation();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector3d p = 1e3 * pose.translation();
  return {{"position_mm", {p.x(), p.y(), p.z()}},
          {"quaternion", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}};
}

}  // namespace geond::daemon
