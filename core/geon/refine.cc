// SPDX-License-Identifier: Apache-2.0
#include "core/geon/refine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "core/geon/shape.h"

namespace geond {
namespace {

double GreatestBend(const GeonState& s) { return std::min(kMaxFold / s.size.x(), std::numbers::pi / s.size.z()); }

// Gradient and Gauss-Newton matrix of sum(smooth) + lambda gamma sum(normal), gamma the mean size: sqrt(gamma) times the
// normals' differences is the residual, so that gamma's own slope comes with it.
struct Quadratic {
  ParameterVector gradient;
  ParameterMatrix matrix;
};

Quadratic QuadraticOf(const MisfitDerivatives& d, double lambda, double gamma, int count) {
  Quadratic q;
  q.matrix = d.hessian;
  for (int k = 0; k < count; ++k) q.gradient[k] = d.distance_gradient[k] + 2.0 * lambda * gamma * d.normal_gradient[k];
  const double third = 1.0 / 3.0;
  for (int i = 6; i < 9; ++i) {
    q.gradient[i] += lambda * d.sums.normal * third;
    for (int k = 0; k < count; ++k) {
      q.matrix(i, k) += lambda * third * d.normal_gradient[k];
      q.matrix(k, i) += lambda * third * d.normal_gradient[k];
    }
    for (int j = 6; j < 9; ++j) q.matrix(i, j) += lambda * d.sums.normal * third * third / (2.0 * gamma);
  }
  return q;
}

// Solves (A + damping diag A) x = -g over the free parameters by Cholesky; false if the matrix is not positive.
bool SolveDamped(const Quadratic& q, const std::array<bool, kMaxParameters>& held, int count, double damping,
                 ParameterVector& step) {
  std::array<int, kMaxParameters> free{};
  int n = 0;
  for (int k = 0; k < count; ++k) if (!held[k]) free[n++] = k;
  double greatest = 0.0;
  for (int i = 0; i < n; ++i) greatest = std::max(greatest, q.matrix(free[i], free[i]));
  // Column by column, so that what each column takes from those behind it does not wait for itself. Row n is the right side.
  std::array<std::array<double, kMaxParameters + 1>, kMaxParameters> columns;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) columns[j][i] = q.matrix(free[i], free[j]);
    columns[j][j] += damping * columns[j][j] + 1e-12 * greatest;
    columns[j][n] = -q.gradient[free[j]];
  }
  std::array<double, kMaxParameters> inverse_pivot;
  for (int j = 0; j < n; ++j) {
    if (!(columns[j][j] > 0.0)) return false;
    inverse_pivot[j] = 1.0 / std::sqrt(columns[j][j]);
    for (int i = j + 1; i <= n; ++i) columns[j][i] *= inverse_pivot[j];
    for (int k = j + 1; k < n; ++k) {
      const double factor = columns[j][k];
      for (int i = k; i <= n; ++i) columns[k][i] -= factor * columns[j][i];
    }
  }
  step.setZero();
  for (int j = n - 1; j >= 0; --j) {
    double sum = columns[j][n];
    for (int i = j + 1; i < n; ++i) sum -= columns[j][i] * step[free[i]];
    step[free[j]] = sum * inverse_pivot[j];
  }
  return true;
}

// The parameters that stand at a bound with the slope pressing them against it.
std::array<bool, kMaxParameters> HeldByBounds(const GeonState& s, const ParameterVector& gradient,
                                              const ParameterBounds& bounds) {
  std::array<bool, kMaxParameters> held{};
  const auto check = [&](int k, double value, double low, double high) {
    held[k] = (value <= low && gradient[k] > 0.0) || (value >= high && gradient[k] < 0.0);
  };
  for (int i = 0; i < 3; ++i) check(6 + i, s.size[i], bounds.least_size, bounds.greatest_size);
  if (IsTapered(s.type)) for (int i = 0; i < 2; ++i) check(9 + i, s.deformation[i], 0.0, kMaxTaper);
  if (IsCurved(s.type)) check(9, s.deformation[0], 0.0, GreatestBend(s) * (1.0 - 1e-12));
  return held;
}

}  // namespace

GeonState Bounded(const GeonState& state, const ParameterBounds& bounds) {
  GeonState s = state;
  for (int i = 0; i < 3; ++i) {
    s.size[i] = std::clamp(s.size[i], bounds.least_size, bounds.greatest_size);
    s.center[i] = std::clamp(s.center[i], bounds.center[i] - bounds.reach, bounds.center[i] + bounds.reach);
  }
  if (s.gamma() < bounds.least_gamma) s.size *= bounds.least_gamma / s.gamma();
  if (IsTapered(s.type)) for (int i = 0; i < 2; ++i) s.deformation[i] = std::clamp(s.deformation[i], 0.0, kMaxTaper);
  if (IsCurved(s.type)) s.deformation[0] = std::clamp(s.deformation[0], 0.0, GreatestBend(s));
  return s;
}

GeonState Stepped(const GeonState& state, const ParameterVector& step, const ParameterBounds& bounds) {
  GeonState s = state;
  const Eigen::Vector3d w = step.head<3>();
  const double angle = w.norm();
  Eigen::Quaterniond turn(1.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z());
  if (angle > 1e-12) {
    turn.w() = std::cos(0.5 * angle);
    turn.vec() = std::sin(0.5 * angle) / angle * w;
  }
  s.rotation = (Eigen::Quaterniond(state.rotation) * turn).normalized().toRotationMatrix();
  s.center += state.rotation * step.segment<3>(3);
  s.size += step.segment<3>(6);
  if (IsTapered(s.type)) s.deformation += step.tail<2>();
  if (IsCurved(s.type)) s.deformation[0] += step[9];
  return Bounded(s, bounds);
}

RefineResult Refine(const GeonState& start, const LanePoints& points, const ParameterBounds& bounds,
                    const RefineOptions& options) {
  RefineResult result;
  result.state = Bounded(start, bounds);
  const int count = ParameterCount(start.type);
  const auto total = [&](const MisfitSums& sums, double gamma) {
    return (sums.smooth + options.lambda * gamma * sums.normal) / sums.weight;
  };
  // Most steps are accepted, so their derivatives are had with their sums: at once, but for a step after a rejected one and
  // for the last.
  MisfitDerivatives d, next;
  bool has_derivatives = false;
  double damping = options.damping;
  for (int iteration = 0; iteration < options.iterations && !result.converged;) {
    const GeonState s = result.state;
    const double gamma = s.gamma();
    if (!has_derivatives) {
      DifferentiateMisfit(s, points, 2.0 * options.lambda * gamma, options.floor, d);
      ++result.evaluations;
    }
    has_derivatives = false;
    result.objective = total(d.sums, gamma);
    result.t1 = d.sums.distance / d.sums.weight;
    result.t2 = d.sums.normal / d.sums.weight;
    const Quadratic q = QuadraticOf(d, options.lambda, gamma, count);
    const std::array<bool, kMaxParameters> held = HeldByBounds(s, q.gradient, bounds);
    bool moved = false, rejected = false;
    for (; !moved && iteration < options.iterations; ++iteration) {
      ParameterVector step;
      if (!SolveDamped(q, held, count, damping, step)) {
        damping = std::max(1e-6, 10.0 * damping);
        continue;
      }
      // No turn by more than a radian at once, no size to nothing.
      double shorten = 1.0;
      const double turn = step.head<3>().norm();
      if (turn > 0.7) shorten = 0.7 / turn;
      for (int i = 0; i < 3; ++i) {
        if (step[6 + i] < -0.6 * s.size[i]) shorten = std::min(shorten, -0.6 * s.size[i] / step[6 + i]);
        if (step[6 + i] > 1.5 * s.size[i]) shorten = std::min(shorten, 1.5 * s.size[i] / step[6 + i]);
      }
      step *= shorten;
      const GeonState trial = Stepped(s, step, bounds);
      const bool with_derivatives = !rejected && iteration + 1 < options.iterations;
      if (with_derivatives) DifferentiateMisfit(trial, points, 2.0 * options.lambda * trial.gamma(), options.floor, next);
      const MisfitSums sums = with_derivatives ? next.sums : SumMisfit(trial, points, options.floor);
      ++result.evaluations;
      const double objective = total(sums, trial.gamma());
      const double gain = result.objective - objective;
      if (gain > 0.0) {
        moved = true;
        has_derivatives = with_derivatives;
        if (with_derivatives) std::swap(d, next);
        result.state = trial;
        result.objective = objective;
        result.t1 = sums.distance / sums.weight;
        result.t2 = sums.normal / sums.weight;
        damping = std::max(1e-9, 0.2 * damping);
        result.converged = gain <= options.tolerance * objective || step.norm() < options.tolerance;
      } else {
        rejected = true;
        damping = std::max(1e-6, 6.0 * damping);
        if (step.norm() < options.tolerance || damping > 1e8) result.converged = true;
        if (result.converged) break;
      }
    }
    if (!moved) break;
  }
  return result;
}

}  // namespace geond
