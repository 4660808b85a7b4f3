// SPDX-License-Identifier: Apache-2.0
// One form for each shape. The 24 rotations that permute and flip the axes carry a geon into forms of the same shape with
// permuted sizes and signs; of those that obey the order below, the one whose frame turns least against T is kept.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geon/geon.h"

namespace geond {
namespace {

constexpr double kEqual = 1e-9;  // relative: sizes closer than this are the same

std::vector<Eigen::Matrix3d> AxisRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  for (const auto& o : order) {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
      for (int i = 0; i < 3; ++i) m(o[i], i) = (signs >> i) & 1 ? -1.0 : 1.0;
      if (m.determinant() > 0.0) rotations.push_back(m);
    }
  }
  return rotations;
}

bool NotLess(double a, double b) { return a >= b - kEqual * std::max(std::abs(a), std::abs(b)); }
bool Same(double a, double b) { return NotLess(a, b) && NotLess(b, a); }

// The rotation that turns `axis` (a unit vector of G) where `q` turns it and nothing about it.
Eigen::Quaterniond WithoutTwist(const Eigen::Quaterniond& q, const Eigen::Vector3d& axis) {
  Eigen::Quaterniond twist;
  twist.w() = q.w();
  twist.vec() = axis * axis.dot(q.vec());
  if (twist.norm() < 1e-12) return q;   // half a turn about an axis across it: no twist is defined
  return q * twist.normalized().conjugate();
}

// The geon seen from axes turned by `r`: the same shape, other numbers.
Geon Turned(const Geon& geon, const Eigen::Matrix3d& r) {
  Geon turned = geon;
  turned.X_TG = geon.X_TG * Pose(r, Eigen::Vector3d::Zero());
  turned.size = (r.cwiseAbs().transpose() * geon.size).eval();
  if (IsTapered(geon.type)) {
    const Eigen::Vector2d taper = r(2, 2) * (r.topLeftCorner<2, 2>().cwiseAbs().transpose() * geon.taper);
    turned.taper = taper + Eigen::Vector2d::Zero();
  }
  if (IsCurved(geon.type)) turned.bend = r(0, 0) * geon.bend;
  return turned;
}

// Ellipsoid and cuboid: z the longest, x not shorter than y. Cylinders and tapered shapes: x not shorter than y. Tapers and
// bend not negative.
bool InOrder(const Geon& g) {
  if (g.type == GeonType::kEllipsoid || g.type == GeonType::kCuboid) {
    return NotLess(g.size.z(), g.size.x()) && NotLess(g.size.x(), g.size.y());
  }
  if (IsCurved(g.type) && g.bend != 0.0) return g.bend > 0.0;
  if (!NotLess(g.size.x(), g.size.y())) return false;
  if (!IsTapered(g.type)) return true;
  if (Same(g.size.x(), g.size.y()) && !NotLess(g.taper.x(), g.taper.y())) return false;
  return g.taper.sum() >= 0.0;
}

bool Allowed(const Geon& geon, const Eigen::Matrix3d& r) {
  if (geon.type == GeonType::kEllipsoid || geon.type == GeonType::kCuboid) return true;
  if (std::abs(r(2, 2)) < 0.5) return false;
  return !IsCurved(geon.type) || geon.bend == 0.0 || std::abs(r(0, 0)) > 0.5;
}

}  // namespace

Geon Canonical(const Geon& geon) {
  static const std::vector<Eigen::Matrix3d> rotations = AxisRotations();
  Geon start = geon;
  if (!IsTapered(start.type)) start.taper.setZero();
  if (!IsCurved(start.type)) start.bend = 0.0;
  Geon best = start;
  double best_w = -1.0;
  for (const Eigen::Matrix3d& r : rotations) {
    if (!Allowed(start, r)) continue;
    Geon candidate = Turned(start, r);
    if (!InOrder(candidate)) continue;
    Eigen::Quaterniond q = candidate.X_TG.rotation();
    const Eigen::Vector3d& a = candidate.size;
    if (BaseType(candidate.type) != GeonType::kCuboid && candidate.bend == 0.0) {
      const bool about_z = Same(a.x(), a.y()) && Same(candidate.taper.x(), candidate.taper.y());
      const bool about_y = candidate.type == GeonType::kEllipsoid && Same(a.z(), a.x());
      if (about_z && about_y) q = Eigen::Quaterniond::Identity();   // a sphere
      else if (about_z) q = WithoutTwist(q, Eigen::Vector3d::UnitZ());
      else if (about_y) q = WithoutTwist(q, Eigen::Vector3d::UnitY());
    }
    if (q.w() < 0.0) q.coeffs() = -q.coeffs();
    candidate.X_TG = Pose(q, candidate.X_TG.translation());
    if (q.w() > best_w + 1e-12) {
      best_w = q.w();
      best = candidate;
    }
  }
  return best;
}

}  // namespace geond
