// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/description_change.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/printed.h"

namespace geond::daemon {
namespace {

constexpr double kDeviations = 2.0;
constexpr double kRelative = 0.03;
constexpr double kLeast = 0.3;  // mm

double Distance(const Json& a, const Json& b) {
  double squares = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d = a["pose"]["position_mm"][k].get<double>() - b["pose"]["position_mm"][k].get<double>();
    squares += d * d;
  }
  return std::sqrt(squares);
}

// Standard deviation of a size, mm; infinite where the data do not say.
double SizeDeviation(const Json& part, int axis) {
  if (!part.contains("deviation")) return 0.0;
  const Json& value = part["deviation"]["size_mm"][axis];
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::infinity();
}

std::string PartChange(const Json& before, const Json& after) {
  const std::string type = after["type"].get<std::string>(), was = before["type"].get<std::string>();
  const int id = after["id"].get<int>();
  if (type != was) return Printed("part %d is described as %s, before as %s", id, type.c_str(), was.c_str());
  for (int axis = 0; axis < 3; ++axis) {
    const double now = after["size_mm"][axis].get<double>(), then = before["size_mm"][axis].get<double>();
    const double known = SizeDeviation(after, axis), was_known = SizeDeviation(before, axis);
    if (std::isfinite(known) && !std::isfinite(was_known)) return Printed("a size of part %d is known now", id);
    const double allowed = std::max({kLeast, kRelative * now, kDeviations * std::hypot(known, was_known)});
    if (std::abs(now - then) > allowed) return Printed("a half size of part %d is %.1f mm and was %.1f mm", id, now, then);
  }
  return {};
}

}  // namespace

std::string WhatChanged(const Json& before, const Json& after) {
  const int n = after["n_parts"].get<int>(), was = before["n_parts"].get<int>();
  if (n != was) return Printed("%d part%s, %d before", n, n == 1 ? "" : "s", was);
  std::vector<bool> taken(before["parts"].size(), false);
  for (const Json& part : after["parts"]) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < taken.size(); ++k) {
      const double distance = Distance(before["parts"][k], part);
      if (!taken[k] && distance < least) nearest = k, least = distance;
    }
    taken[nearest] = true;
    const std::string change = PartChange(before["parts"][nearest], part);
    if (!change.empty()) return change;
  }
  return {};
}

}  // namespace geond::daemon
