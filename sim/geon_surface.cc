// SPDX-License-Identifier: Apache-2.0
#include "sim/geon_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace geond::sim {
namespace {

constexpr double kFlatBend = 1e-12;    // 1/m: less is no bend
constexpr double kLeastFactor = 1e-3;  // taper factor, where (5.5) would divide by zero beyond the apex

double Pow20(double x) {
  const double x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
  return x8 * x8 * x4;
}
double Pow19(double x) {
  const double x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
  return x8 * x8 * x2 * x;
}

// (|a|^20 + |b|^20)^(1/20) and its derivatives, scaled by the larger so that nothing overflows.
double Norm20(double a, double b, double& da, double& db) {
  const double scale = std::max(std::abs(a), std::abs(b));
  if (!(scale > 0.0)) {
    da = db = 0.0;
    return 0.0;
  }
  const double u = a / scale, v = b / scale;
  const double root = std::pow(Pow20(u) + Pow20(v), 0.05);
  const double weight = 1.0 / Pow19(root);
  da = Pow19(u) * weight;
  db = Pow19(v) * weight;
  return scale * root;
}

// f^(1/p) of the regular primitive in half sizes: a norm, so convex along every line.
double RegularNorm(GeonType base, const Eigen::Vector3d& q, Eigen::Vector3d& gradient) {
  if (base == GeonType::kEllipsoid) {
    const double norm = q.norm();
    gradient = norm > 0.0 ? Eigen::Vector3d(q / norm) : Eigen::Vector3d::Zero();
    return norm;
  }
  if (base == GeonType::kCylinder) {
    const double radius = std::hypot(q.x(), q.y());
    double d_radius, d_z;
    const double norm = Norm20(radius, q.z(), d_radius, d_z);
    const double share = radius > 0.0 ? d_radius / radius : 0.0;
    gradient = {share * q.x(), share * q.y(), d_z};
    return norm;
  }
  double d_x, d_y, d_xy, d_z;
  const double xy = Norm20(q.x(), q.y(), d_x, d_y);
  const double norm = Norm20(xy, q.z(), d_xy, d_z);
  gradient = {d_xy * d_x, d_xy * d_y, d_z};
  return norm;
}

void Check(const Geon& geon) {
  const auto refuse = [&](const std::string& what) { throw std::invalid_argument("geon: " + what); };
  for (const double a : geon.size) {
    if (!(a > 0.0) || !(a < 10.0)) refuse("every half size must be above 0 and below 10 m");
  }
  if (!IsTapered(geon.type) && geon.taper != Eigen::Vector2d::Zero()) {
    refuse("a taper belongs to tapered types only, not to " + std::string(GeonTypeName(geon.type)));
  }
  if (!IsCurved(geon.type) && geon.bend != 0.0) {
    refuse("a bend belongs to curved types only, not to " + std::string(GeonTypeName(geon.type)));
  }
  for (const double k : geon.taper) {
    if (!(k >= 0.0) || !(k <= 0.98)) refuse("a taper must be from 0 to 0.98 (the +z end is the larger)");
  }
  if (!(geon.bend >= 0.0)) refuse("a bend must be 0 or more (it is towards +x)");
  if (geon.bend * geon.size.x() >= 0.98) {
    refuse("bent so much that the inside folds over: bend times the half size x must be below 0.98");
  }
  if (geon.bend * geon.size.z() > std::numbers::pi) {
    refuse("bent beyond a full ring: bend times the half size z must be at most pi");
  }
}

}  // namespace

GeonSurface::GeonSurface(const Geon& geon) : geon_(geon), X_GT_(Inverse(geon.X_TG)), R_GT_(X_GT_.matrix()) {
  Check(geon_);
  BuildShell();
}

GeonSurface::Value GeonSurface::At(const Eigen::Vector3d& p_T) const {
  const Eigen::Vector3d p = X_GT_ * p_T;
  const Eigen::Vector3d& a = geon_.size;
  // x, y, z before the deformation, and the rows of d(x, y, z)/d(X, Y, Z).
  Eigen::Vector3d q = p;
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  const double kappa = geon_.bend;
  if (kappa > kFlatBend) {
    const double c = 1.0 - kappa * p.x(), s = kappa * p.z();
    const double r2 = c * c + s * s;
    const double r = std::sqrt(std::max(r2, 1e-300));
    q.x() = (2.0 * p.x() - kappa * (p.x() * p.x() + p.z() * p.z())) / (1.0 + r);
    q.z() = std::atan2(s, c) / kappa;
    J << c / r, 0.0, -s / r,  //
        0.0, 1.0, 0.0,        //
        s / r2, 0.0, c / r2;
  } else if (IsTapered(geon_.type)) {
    for (int axis = 0; axis < 2; ++axis) {
      const double slope = geon_.taper[axis] / a.z();
      const double factor = slope * p.z() + 1.0;
      const double kept = std::max(factor, kLeastFactor);
      q[axis] = p[axis] / kept;
      J(axis, axis) = 1.0 / kept;
      J(axis, 2) = factor > kLeastFactor ? -p[axis] * slope / (kept * kept) : 0.0;
    }
  }
  Eigen::Vector3d gradient;
  const double value = RegularNorm(BaseType(geon_.type), q.cwiseQuotient(a), gradient);
  return {value, R_GT_.transpose() * (J.transpose() * gradient.cwiseQuotient(a))};
}

Eigen::Vector3d GeonSurface::Deform(const Eigen::Vector3d& direction, double level) const {
  Eigen::Vector3d unused;
  const double norm = RegularNorm(BaseType(geon_.type), direction, unused);
  Eigen::Vector3d q = (level / norm) * direction.cwiseProduct(geon_.size);
  const double kappa = geon_.bend;
  if (kappa > kFlatBend) {
    const double angle = kappa * q.z(), half = std::sin(0.5 * angle);
    q = {2.0 * half * half / kappa + std::cos(angle) * q.x(), q.y(), (1.0 / kappa - q.x()) * std::sin(angle)};
  } else if (IsTapered(geon_.type)) {
    for (int axis = 0; axis < 2; ++axis) {
      q[axis] *= std::max(geon_.taper[axis] * q.z() / geon_.size.z() + 1.0, kLeastFactor);
    }
  }
  return geon_.X_TG * q;
}

// A grid on each face of the cube, drawn onto the level set of the norm. The grid lines are denser towards the cube's
// edges, where cylinders and cuboids turn.
void GeonSurface::BuildShell() {
  const int n = geon_.bend * geon_.size.z() > 1.0 ? 64 : 40;
  const auto grid = [&](int i) {
    const double u = 2.0 * i / n - 1.0;
    return BaseType(geon_.type) == GeonType::kEllipsoid ? std::tan(0.25 * std::numbers::pi * u)
                                                        : 0.35 * u + 0.65 * std::sin(0.5 * std::numbers::pi * u);
  };
  lowest_z_ = std::numeric_limits<double>::infinity();
  highest_z_ = -lowest_z_;
  const double ring_gap = geon_.bend > kFlatBend ? std::numbers::pi / (geon_.bend * geon_.size.z()) : 2.0;
  for (double margin = 0.004; margin < 0.2; margin *= 1.5) {
    // A geon bent to a ring must not let its shell run past the cut on the far side.
    const double level = 1.0 + std::min(margin, std::max(1e-6, ring_gap - 1.0));
    shell_ = {};
    bool outside = true;
    for (int face = 0; face < 6; ++face) {
      const int axis = face / 2, u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
      const double side = face % 2 ? -1.0 : 1.0;
      const int base = static_cast<int>(shell_.vertices.size());
      for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
          Eigen::Vector3d direction;
          direction[axis] = side;
          direction[u_axis] = side * grid(i);
          direction[v_axis] = grid(j);
          shell_.vertices.push_back(Deform(direction, level));
          const double z = Deform(direction, 1.0).z();
          lowest_z_ = std::min(lowest_z_, z);
          highest_z_ = std::max(highest_z_, z);
        }
      }
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const int v00 = base + j * (n + 1) + i, v10 = v00 + 1, v01 = v00 + n + 1, v11 = v01 + 1;
          shell_.triangles.push_back({v00, v10, v11});
          shell_.triangles.push_back({v00, v11, v01});
        }
      }
    }
    for (const auto& t : shell_.triangles) {
      const Eigen::Vector3d &p0 = shell_.vertices[t[0]], &p1 = shell_.vertices[t[1]], &p2 = shell_.vertices[t[2]];
      for (const Eigen::Vector3d& p : {Eigen::Vector3d((p0 + p1 + p2) / 3.0), Eigen::Vector3d(0.5 * (p0 + p1)),
                                       Eigen::Vector3d(0.5 * (p1 + p2)), Eigen::Vector3d(0.5 * (p2 + p0))}) {
        outside = outside && At(p).value > 1.0;
      }
    }
    if (outside) break;
  }
  reach_ = BoundingBox(shell_.vertices).diagonal().norm();
}

std::optional<double> GeonSurface::Meet(const Eigen::Vector3d& origin_T, const Eigen::Vector3d& direction_T,
                                        double t_enter) const {
  const auto at = [&](double t, double& slope) {
    const Value v = At(origin_T + t * direction_T);
    slope = v.gradient.dot(direction_T);
    return v.value - 1.0;
  };
  const double t_end = t_enter + reach_;
  double t = t_enter, slope;
  double g = at(t, slope);
  if (g < 0.0) return std::nullopt;  // starts inside: that entry belongs to another sheet of the shell
  double outside = t, inside = std::numeric_limits<double>::quiet_NaN();
  for (int iteration = 0; iteration < 100; ++iteration) {
    if (std::abs(g) < 1e-14) return t;
    double next;
    if (g > 0.0) {
      outside = t;
      if (std::isnan(inside)) {
        if (slope >= 0.0) return std::nullopt;  // past the nearest approach without touching
        if (t >= t_end) return std::nullopt;
        next = std::min(t - g / slope, t_end);
      } else {
        next = slope < 0.0 ? t - g / slope : 0.5 * (outside + inside);
      }
    } else {
      inside = t;
      next = slope < 0.0 ? t - g / slope : 0.5 * (outside + inside);
    }
    if (!std::isnan(inside) && !(next > outside && next < inside)) next = 0.5 * (outside + inside);
    if (std::abs(next - t) < 1e-16 + 4e-16 * std::abs(t)) return next;
    t = next;
    g = at(t, slope);
  }
  return std::isnan(inside) ? std::nullopt : std::optional(t);
}

}  // namespace geond::sim
