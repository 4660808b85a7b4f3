// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "core/geon/geon.h"

namespace geond {

// Random numbers that are the same with every standard library.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform(0.0, 1.0)));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform(0.0, 1.0));
  }
  Eigen::Vector3d Normal3() {
    const double x = Normal(), y = Normal(), z = Normal();
    return {x, y, z};
  }
  Eigen::Quaterniond Rotation() {
    const double w = Normal();
    const Eigen::Vector3d v = Normal3();
    return Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized();
  }

 private:
  std::mt19937_64 engine_;
};

// Half sizes with a ratio up to 3.3, tapers 0.25 to 0.9, half bending angles 0.35 to 1.4 rad; some metres about the origin.
inline Geon RandomGeon(GeonType type, Draw& draw, double scale = 0.02) {
  Geon geon;
  geon.type = type;
  for (int i = 0; i < 3; ++i) geon.size[i] = scale * draw.Uniform(1.0, 3.3);
  if (IsCurved(type)) {
    geon.size.x() = scale * draw.Uniform(0.6, 1.0);
    geon.size.y() = scale * draw.Uniform(0.6, 1.0);
    geon.size.z() = scale * draw.Uniform(1.8, 3.0);
    geon.bend = std::min(draw.Uniform(0.35, 1.4) / geon.size.z(), 0.85 / geon.size.x());
  }
  if (IsTapered(type)) geon.taper = {draw.Uniform(0.25, 0.9), draw.Uniform(0.25, 0.9)};
  const Eigen::Quaterniond rotation = draw.Rotation();
  geon.X_TG = Pose(rotation, 3.0 * scale * draw.Normal3());
  return geon;
}

}  // namespace geond
