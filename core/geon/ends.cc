// SPDX-License-Identifier: Apache-2.0
#include "core/geon/ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Geometry>

#include "core/geon/shape.h"

namespace geond {
namespace {

// Share of the points that a face needs to be called seen; of one that is cut to a neighbour, where data are doubtful.
constexpr double kLeastFace = 0.008, kLeastCutFace = 0.04;
// Empty places further beyond an end than this share of the half size say nothing about where it is.
constexpr double kFarGap = 0.6;
// A geon that goes beyond its points by less than this share of its size is left as it is.
constexpr double kOverhang = 0.02;

bool Round(GeonType type, int axis) {
  const GeonType base = BaseType(type);
  return base == GeonType::kEllipsoid || (base == GeonType::kCylinder && axis < 2);
}

// Whether a regular point (over the sizes) lies before or behind the end across `axis`.
bool BeforeEnd(GeonType type, int axis, const Eigen::Vector3d& y, double within) {
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  if (Round(type, axis)) within *= 0.55;
  if (BaseType(type) == GeonType::kCylinder && axis == 2) return std::hypot(y[j], y[k]) <= within;
  return std::abs(y[j]) <= within && std::abs(y[k]) <= within;
}

// The n-th greatest, or the least if there are fewer; -infinity of none.
double Greatest(std::vector<double>& values, std::size_t n) {
  if (values.empty()) return -std::numeric_limits<double>::infinity();
  const std::size_t at = std::min(n, values.size()) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end(), std::greater<>());
  return values[at];
}

// The geon with the end across `axis` on side `side` moved by `by` (own unit) along the axis; its other surfaces stay.
GeonState WithEndMoved(const GeonState& state, int axis, int side, double by) {
  GeonState moved = state;
  const double shift = (side == 1 ? 0.5 : -0.5) * by;  // of the centre, along the axis
  Eigen::Vector3d regular = Eigen::Vector3d::Zero();
  regular[axis] = shift;
  moved.center += state.rotation * Deform(GeonOf(state), regular);
  moved.size[axis] += 0.5 * by;
  if (IsTapered(state.type)) {  // along z: the slopes of the sides stay
    for (int k = 0; k < 2; ++k) {
      const double slope = state.deformation[k] / state.size.z(), factor = 1.0 + slope * shift;
      moved.size[k] = state.size[k] * factor;
      moved.deformation[k] = slope * moved.size.z() / factor;
    }
  }
  if (IsCurved(state.type) && axis == 2) {  // along the arc
    moved.rotation =
        state.rotation * Eigen::AngleAxisd(state.deformation[0] * shift, Eigen::Vector3d::UnitY()).toRotationMatrix();
  }
  return moved;
}

}  // namespace

Ends JudgeEnds(const GeonState& state, const FitData& data) {
  Ends ends;
  const Geon geon = GeonOf(state);
  const auto regular = [&](const Eigen::Vector3d& p) {
    return Undeform(geon, state.rotation.transpose() * (p - state.center));
  };
  std::array<std::array<int, 2>, 3> on_face{}, at_cut{};
  std::array<std::array<std::vector<double>, 2>, 3> along;
  for (int i = 0; i < data.all.size; ++i) {
    const Eigen::Vector3d u = regular({data.all.point[0][i], data.all.point[1][i], data.all.point[2][i]});
    const Eigen::Vector3d m = GaugeGradient(geon, u).normalized();
    for (int k = 0; k < 3; ++k) {
      if (std::abs(m[k]) > 0.8) ++on_face[k][m[k] > 0.0];
      along[k][u[k] > 0.0].push_back(std::abs(u[k]));
    }
  }
  for (int k = 0; k < 3; ++k) {
    for (int side = 0; side < 2; ++side) {
      ends.reach[k][side] = std::clamp(Greatest(along[k][side], 3), 0.0, state.size[k]);
      ends.gap[k][side] = std::numeric_limits<double>::infinity();
    }
  }
  for (const Eigen::Vector3d& p : data.around.cuts) {
    const Eigen::Vector3d u = regular(p), y = u.cwiseQuotient(state.size);
    for (int k = 0; k < 3; ++k) {
      const int side = u[k] > 0.0;
      if (std::abs(u[k]) < 0.8 * ends.reach[k][side] || !BeforeEnd(state.type, k, y, Round(state.type, k) ? 1.5 : 1.25))
        continue;
      ++at_cut[k][side];
      along[k][side].push_back(std::min(std::abs(u[k]), state.size[k]));
    }
  }
  std::array<std::array<std::vector<double>, 2>, 3> gaps;
  for (const Eigen::Vector3d& p : data.around.empty) {
    const Eigen::Vector3d u = regular(p), y = u.cwiseQuotient(state.size);
    for (int k = 0; k < 3; ++k) {
      const int side = u[k] > 0.0;
      if (std::abs(u[k]) > ends.reach[k][side] && BeforeEnd(state.type, k, y, 0.9)) {
        gaps[k][side].push_back(-(std::abs(u[k]) - state.size[k]));
      }
    }
  }
  const double n = data.all.size;
  for (int k = 0; k < 3; ++k) {
    for (int side = 0; side < 2; ++side) {
      const bool cut = at_cut[k][side] >= 3;
      if (gaps[k][side].size() >= 2) ends.gap[k][side] = -Greatest(gaps[k][side], 2);
      if (cut) ends.reach[k][side] = std::min(Greatest(along[k][side], 3), state.size[k]);
      const double needed = cut ? kLeastCutFace * n : std::max(2.0, kLeastFace * n);
      ends.state[k][side] = on_face[k][side] >= needed                            ? EndState::kSeen
                            : !cut && ends.gap[k][side] < kFarGap * state.size[k] ? EndState::kBounded
                                                                                  : EndState::kHidden;
    }
  }
  return ends;
}

GeonState WithoutHiddenLength(const GeonState& state, const FitData& data) {
  GeonState shorter = state;
  for (int k = 2; k >= 0; --k) {
    if (Round(state.type, k) || (IsTapered(state.type) && k < 2) || (IsCurved(state.type) && k == 0)) continue;
    const Ends ends = JudgeEnds(shorter, data);
    const double size = shorter.size[k];
    for (int side = 0; side < 2; ++side) {
      const double overhang = size - ends.reach[k][side];
      if (ends.state[k][side] == EndState::kHidden && overhang > 2.0 * kOverhang * size) {
        shorter = WithEndMoved(shorter, k, side, -overhang);
      }
    }
  }
  return shorter;
}

}  // namespace geond
