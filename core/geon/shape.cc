// SPDX-License-Identifier: Apache-2.0
#include "core/geon/shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace geond {
namespace {

double Power10(double x) {
  const double x2 = x * x, x4 = x2 * x2;
  return x4 * x4 * x2;
}

bool IsRound(GeonType type) { return BaseType(type) == GeonType::kCylinder; }

}  // namespace

double Gauge(const Geon& geon, const Eigen::Vector3d& regular) {
  const Eigen::Array3d q = (regular.array() / geon.size.array()).square();
  if (geon.type == GeonType::kEllipsoid) return std::sqrt(q.sum());
  // Scaled by the largest term, so that nothing over- or underflows.
  const Eigen::Array3d term = IsRound(geon.type) ? Eigen::Array3d(q[0] + q[1], q[2], 0.0) : q;
  const double largest = term.maxCoeff();
  if (largest == 0.0) return 0.0;
  const Eigen::Array3d t = term / largest;
  return std::sqrt(largest) * std::pow(Power10(t[0]) + Power10(t[1]) + Power10(t[2]), 0.05);
}

Eigen::Vector3d GaugeGradient(const Geon& geon, const Eigen::Vector3d& regular) {
  const double s = Gauge(geon, regular);
  if (s == 0.0) return Eigen::Vector3d::Zero();
  const Eigen::Array3d y = regular.array() / (geon.size.array() * s);
  const auto power18 = [](double square) { return Power10(square) / square; };
  Eigen::Array3d gradient = y;
  if (geon.type != GeonType::kEllipsoid) {
    const Eigen::Array3d q = y.square();
    const Eigen::Array3d base = IsRound(geon.type) ? Eigen::Array3d(q[0] + q[1], q[0] + q[1], q[2]) : q;
    for (int i = 0; i < 3; ++i) gradient[i] *= base[i] > 0.0 ? power18(base[i]) : 0.0;
  }
  return (gradient / geon.size.array()).matrix();
}

Eigen::Vector3d Deform(const Geon& geon, const Eigen::Vector3d& regular) {
  if (IsTapered(geon.type)) {
    const Eigen::Array2d factor = 1.0 + geon.taper.array() * (regular.z() / geon.size.z());
    return {factor[0] * regular.x(), factor[1] * regular.y(), regular.z()};
  }
  if (IsCurved(geon.type) && geon.bend != 0.0) {
    const double kappa = geon.bend, theta = kappa * regular.z();
    const double half = std::sin(0.5 * theta);
    const double sine_over_kappa = std::abs(theta) < 1e-8 ? regular.z() : std::sin(theta) / kappa;
    return {2.0 * half * half / kappa + std::cos(theta) * regular.x(), regular.y(),
            sine_over_kappa - std::sin(theta) * regular.x()};
  }
  return regular;
}

Eigen::Vector3d Undeform(const Geon& geon, const Eigen::Vector3d& p) {
  if (IsTapered(geon.type)) {
    const Eigen::Array2d factor = (1.0 + geon.taper.array() * (p.z() / geon.size.z())).max(kTaperGuard);
    return {p.x() / factor[0], p.y() / factor[1], p.z()};
  }
  if (IsCurved(geon.type)) {
    const double kappa = geon.bend, c = 1.0 - kappa * p.x(), s = kappa * p.z();
    const double x = (2.0 * p.x() - kappa * (p.x() * p.x() + p.z() * p.z())) / (1.0 + std::hypot(s, c));
    return {x, p.y(), std::abs(kappa) < 1e-12 ? p.z() : std::atan2(s, c) / kappa};
  }
  return p;
}

Eigen::Vector3d SurfaceNormal(const Geon& geon, const Eigen::Vector3d& regular) {
  const Eigen::Vector3d m = GaugeGradient(geon, regular);
  const double s = Gauge(geon, regular);
  const Eigen::Vector3d x_s = s > 0.0 ? Eigen::Vector3d(regular / s) : regular;
  Eigen::Vector3d n = m;
  if (IsTapered(geon.type)) {
    const Eigen::Array2d slope = geon.taper.array() / geon.size.z();
    const Eigen::Array2d factor = 1.0 + slope * x_s.z();
    n = {factor[1] * m.x(), factor[0] * m.y(),
         factor[0] * factor[1] * m.z() - factor[1] * slope[0] * x_s.x() * m.x() - factor[0] * slope[1] * x_s.y() * m.y()};
  } else if (IsCurved(geon.type)) {
    const double theta = geon.bend * x_s.z(), rho = 1.0 - geon.bend * x_s.x();
    const double c = std::cos(theta), sn = std::sin(theta);
    n = {rho * c * m.x() + sn * m.z(), rho * m.y(), c * m.z() - rho * sn * m.x()};
  }
  return n.normalized();
}

void CheckGeon(const Geon& geon) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("geon: " + what); };
  if (!geon.size.allFinite() || geon.size.minCoeff() <= 0.0) fail("half sizes must be finite and positive");
  if (IsTapered(geon.type) && !(geon.taper.minCoeff() >= 0.0 && geon.taper.maxCoeff() < 1.0)) {
    fail("tapers must be at least 0 and below 1");
  }
  if (IsCurved(geon.type)) {
    if (!(geon.bend >= 0.0)) fail("the bend must not be negative");
    if (geon.bend * geon.size.x() >= 1.0) fail("bend times half size x must be below 1, or the shape folds over");
    if (geon.bend * geon.size.z() > std::numbers::pi * (1 + 1e-12)) fail("bend times half size z must not exceed pi");
  }
}

}  // namespace geond
