// SPDX-License-Identifier: Apache-2.0
#include "core/charge/contour.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/LU>

#include "core/base/parallel.h"

namespace geond {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostSegments = 5000;

// -2 times the integral of ln|r - r'| over the segment from a to b, exact: with l the place along the line and P the
// distance to it, the primitive is l ln R - l + P atan(l/P).
double SegmentPotential(const Vector2d& r, const Vector2d& a, const Vector2d& b) {
  const double length = (b - a).norm();
  const Vector2d along = (b - a) / length, to_a = a - r;
  const double l_minus = to_a.dot(along), l_plus = l_minus + length;
  const double P = std::abs(to_a.x() * along.y() - to_a.y() * along.x());
  const auto l_log = [&](double l) { return l == 0.0 ? 0.0 : l * std::log(std::hypot(l, P)); };
  const double angle = std::atan2(P * length, P * P + l_minus * l_plus);
  return -2.0 * (l_log(l_plus) - l_log(l_minus) - length + P * angle);
}

void CheckPolygon(std::span<const Vector2d> polygon) {
  if (polygon.size() < 3) throw std::invalid_argument("a contour needs three vertices or more");
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (!polygon[i].allFinite()) throw std::invalid_argument("vertex " + std::to_string(i) + " of the contour is not finite");
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (polygon[i] == polygon[(i + 1) % polygon.size()]) {
      throw std::invalid_argument("vertex " + std::to_string((i + 1) % polygon.size()) +
                                  " of the contour repeats the one before it: remove it");
    }
  }
  if (polygon.size() > kMostSegments) {
    throw std::invalid_argument("the contour has " + std::to_string(polygon.size()) + " vertices, the exact solve takes " +
                                std::to_string(kMostSegments));
  }
}

}  // namespace

ContourDensity SolveContourCharge(std::span<const Vector2d> polygon, const ContourOptions& options, std::stop_token stop,
                                  const StepObserver& on_step) {
  CheckPolygon(polygon);
  ThrowIfStopped(stop);
  const auto n = static_cast<std::ptrdiff_t>(polygon.size());
  const auto vertex = [&](std::ptrdiff_t i) -> const Vector2d& { return polygon[i % n]; };
  Eigen::VectorXd length(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) length[i] = (vertex(i + 1) - vertex(i)).norm();
  const double scale = length.sum();  // the equations are written for a contour of length 1

  if (on_step) on_step("contour charge: matrix", 0, 0);
  Eigen::MatrixXd A(n + 1, n + 1);
  ParallelFor(n, options.threads, 16, [&](std::ptrdiff_t k) {
    const Vector2d a = vertex(k) / scale, b = vertex(k + 1) / scale;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      A(i, k) = SegmentPotential((vertex(i) + vertex(i + 1)) / (2.0 * scale), a, b);
    }
  });
  A.row(n).head(n) = length / scale;
  A.col(n).head(n).setConstant(-1.0);
  A(n, n) = 0.0;
  ThrowIfStopped(stop);
  if (on_step) on_step("contour charge: solve", 0, 0);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + 1);
  right[n] = 1.0;
  const Eigen::VectorXd x = A.partialPivLu().solve(right);

  ContourDensity result;
  result.summary.residual = (A * x - right).norm();
  result.summary.converged = result.summary.residual < 1e-9;
  result.summary.message = result.summary.converged ? "solved by LU" : "the matrix is close to singular";
  result.segment_density.resize(n);
  result.density.resize(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) result.segment_density[i] = x[i] / scale;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    result.density[i] = 0.5 * (result.segment_density[i] + result.segment_density[(i + n - 1) % n]);
  }
  result.potential = x[n] - 2.0 * std::log(scale);
  return result;
}

}  // namespace geond
