// SPDX-License-Identifier: Apache-2.0
#include "calib/depth_jumps.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace geond::calib {
namespace {

constexpr std::array<std::array<int, 2>, 8> kDirections = {
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}};

struct Neighborhood {
  const RangeView& view;
  double slope;  // of depth over lateral distance at the greatest incidence

  double Depth(int column, int row) const {
    if (!view.image.contains(column, row)) return std::nan("");
    const std::size_t i = view.image.index(column, row);
    return view.classes[i] == PixelClass::kNothing ? std::nan("") : view.image.depth[i];
  }
  // Lateral distance of two neighbouring pixels at a depth, m.
  double Pitch(double depth, int du, int dv) const {
    const double scale = view.sensor.projection == SensorModel::Projection::kPerspective ? depth : 1.0;
    return std::hypot(du * scale / view.sensor.focal_u, dv * scale / view.sensor.focal_v);
  }
  bool Jump(double a, double b, int du, int dv) const {
    const double limit = 6.0 * view.sensor.depth_noise + slope * Pitch(std::min(a, b), du, dv);
    return std::abs(a - b) > limit;
  }
};

bool IsMixed(const Neighborhood& around, int column, int row) {
  const double here = around.Depth(column, row);
  int smooth = 0;
  bool leaves = false;
  for (const auto& [du, dv] : kDirections) {
    const double beyond = around.Depth(column + du, row + dv);
    if (!std::isfinite(beyond)) continue;
    if (!around.Jump(here, beyond, du, dv)) {
      ++smooth;
      continue;
    }
    const double inner = around.Depth(column - du, row - dv);
    if (!std::isfinite(inner)) continue;
    if (around.Jump(here, inner, du, dv)) return true;  // hangs between two surfaces
    const double inner2 = around.Depth(column - 2 * du, row - 2 * dv);
    if (!std::isfinite(inner2) || around.Jump(inner, inner2, du, dv)) continue;
    const double drawn = (here - (2.0 * inner - inner2)) * (beyond > here ? 1.0 : -1.0);  // towards the other surface
    const double tolerance = 4.0 * std::sqrt(6.0) * around.view.sensor.depth_noise +
                             0.5 * std::abs(inner - inner2) + around.Pitch(here, du, dv);
    if (drawn > tolerance) leaves = true;
  }
  return leaves || smooth < 2;
}

}  // namespace

void RejectMixedPixels(RangeView& view, double max_incidence) {
  const Neighborhood around{view, std::tan(std::clamp(max_incidence, 0.1, 1.55))};
  std::vector<std::size_t> mixed;
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      const std::size_t i = view.image.index(column, row);
      if (view.classes[i] == PixelClass::kObject && IsMixed(around, column, row)) mixed.push_back(i);
    }
  }
  for (const std::size_t i : mixed) view.classes[i] = PixelClass::kRejected;
}

}  // namespace geond::calib
