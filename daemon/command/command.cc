// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/command.h"

#include <cstdarg>
#include <cstdio>
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

std::string Format(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(length + 1, '\0');
  std::vsnprintf(text.data(), text.size(), format, again);
  va_end(again);
  text.pop_back();
  return text;
}

}  // namespace geond::daemon
