// SPDX-License-Identifier: Apache-2.0
#include "core/charge/contour.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/LU>

#include "core/base/parallel.h"
#include "core/charge/circulant.h"
#include "core/charge/contour_potential.h"
#include "core/charge/gmres.h"

namespace geond {
namespace {

using charge::Contour;
using Eigen::Vector2d;

constexpr std::ptrdiff_t kDenseByItself = 600;  // segments up to which the whole matrix is chosen
constexpr std::ptrdiff_t kMostDense = 10000;    // up to which it is made at all

// The contour without a last vertex that repeats the first, in lengths of its perimeter. Its capacity is then at most
// 1/(2 pi), so that the potential of unit charge is well above zero and the matrix positive.
Contour MakeContour(std::span<const Vector2d> polygon, double& perimeter) {
  if (polygon.size() > 1 && polygon.front() == polygon.back()) polygon = polygon.first(polygon.size() - 1);
  if (polygon.size() < 3) throw std::invalid_argument("a contour needs three vertices or more");
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (!polygon[i].allFinite())
      throw std::invalid_argument("vertex " + std::to_string(i) + " of the contour is not finite");
  }
  perimeter = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double length = (polygon[(i + 1) % polygon.size()] - polygon[i]).norm();
    if (!(length > 0.0)) {
      throw std::invalid_argument("vertex " + std::to_string((i + 1) % polygon.size()) +
                                  " of the contour repeats the one before it: remove it");
    }
    perimeter += length;
  }
  Contour contour;
  for (const Vector2d& p : polygon)
    contour.vertex.emplace_back((p.x() - polygon[0].x()) / perimeter, (p.y() - polygon[0].y()) / perimeter);
  for (std::ptrdiff_t k = 0; k < contour.size(); ++k)
    contour.length.push_back(std::abs(contour.end(k) - contour.vertex[k]));
  return contour;
}

// The charges of the segments for potential 1, by LU of the whole matrix.
std::vector<double> SolveWhole(const Contour& contour, int threads, SolveSummary& summary) {
  const std::ptrdiff_t n = contour.size();
  Eigen::MatrixXd A(n, n);
  ParallelFor(n, threads, 16, [&](std::ptrdiff_t k) {
    for (std::ptrdiff_t i = 0; i < n; ++i) A(i, k) = charge::SegmentPotential(contour, k, contour.middle(i));
  });
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n), x = A.partialPivLu().solve(ones);
  summary.residual = (A * x - ones).norm() / ones.norm();
  summary.converged = summary.residual < 1e-9;
  summary.message =
      summary.converged ? "solved by LU" : "the matrix is close to singular: does the contour run over itself?";
  return {x.data(), x.data() + n};
}

// On a circle of n equal segments charges that vary k times around make the potential n/k of their size, and even ones
// -2 n ln(radius): the inverse of that is a good one for any smooth contour.
charge::Circulant CircleInverse(std::ptrdiff_t n) {
  const double pi = std::numbers::pi, size = static_cast<double>(n);
  const std::ptrdiff_t last = (n - 1) / 2;
  const auto m = static_cast<double>(last);
  std::vector<double> column(n);
  for (std::ptrdiff_t j = 0; j < n; ++j) {
    const double angle = 2.0 * pi * static_cast<double>(j) / size;
    // The sum of k cos(k angle) up to m.
    const double sum = j == 0 ? 0.5 * m * (m + 1.0)
                              : ((m + 1.0) * std::cos(m * angle) - m * std::cos((m + 1.0) * angle) - 1.0) /
                                    (4.0 * std::pow(std::sin(0.5 * angle), 2));
    const double even = n % 2 == 0 ? (j % 2 == 0 ? 0.5 : -0.5) * size : 0.0;
    column[j] = (0.5 / std::log(2.0 * pi) + 2.0 * sum + even) / (size * size);
  }
  return charge::Circulant(column);
}

std::vector<double> SolveByMultipoles(const Contour& contour, const ContourOptions& options,
                                      const std::stop_token& stop, const StepObserver& on_step,
                                      ContourDensity& result) {
  // Each term of the multipoles adds less than 0.43 of the one before. The density sees their error some thousand times
  // larger, for its finest ripples cause the least potential.
  const int order =
      std::clamp(static_cast<int>(std::ceil(std::log(1e-4 * options.tolerance) / std::log(0.43))), 12, 34);
  if (on_step) on_step("contour charge: matrix", 0, 0);
  const charge::ContourPotential potential(contour, order, options.threads, stop);
  const charge::Circulant inverse = CircleInverse(contour.size());
  if (on_step) on_step("contour charge: solve", 0, 0);
  charge::GmresOptions gmres;
  gmres.tolerance = 1e-13;
  gmres.max_iterations = 300;
  gmres.threads = options.threads;
  // In charges the mean square over the segments, each in charge per share of the perimeter.
  const std::vector<double> weights(contour.size(), 1.0 / static_cast<double>(contour.size()));
  gmres.weights = weights;
  gmres.error_tolerance = 0.1 * options.tolerance;
  const std::vector<double> ones(contour.size(), 1.0);
  charge::GmresResult solved = charge::SolveGmres(
      [&](std::span<const double> x, std::span<double> y) { potential.Apply(x, y); },
      [&](std::span<const double> x, std::span<double> y) { inverse.Apply(x, y); }, ones, gmres, stop,
      [&](int iteration, double) {
        if (on_step) on_step("contour charge: solve", iteration, 0);
      });
  result.summary = solved.summary;
  result.error_estimate = solved.error_estimate;
  return std::move(solved.x);
}

}  // namespace

ContourDensity SolveContourCharge(std::span<const Vector2d> polygon, const ContourOptions& options,
                                  std::stop_token stop, const StepObserver& on_step) {
  if (!(options.tolerance > 0.0)) throw std::invalid_argument("the tolerance of the charge must be positive");
  double perimeter = 0.0;
  const Contour contour = MakeContour(polygon, perimeter);
  ThrowIfStopped(stop);
  const auto start = std::chrono::steady_clock::now();
  ContourDensity result;
  using Solver = ContourOptions::Solver;
  const bool whole =
      options.solver == Solver::kDense || (options.solver == Solver::kAuto && contour.size() <= kDenseByItself);
  if (whole && contour.size() > kMostDense) {
    throw std::invalid_argument("the whole matrix takes up to " + std::to_string(kMostDense) +
                                " segments and the contour has " + std::to_string(contour.size()) +
                                ": use the fast solver");
  }
  const std::vector<double> charges = whole ? SolveWhole(contour, options.threads, result.summary)
                                            : SolveByMultipoles(contour, options, stop, on_step, result);
  double total = 0.0;
  for (double q : charges) total += q;
  const auto n = charges.size();
  result.segment_density.resize(n);
  result.density.resize(n);
  for (std::size_t i = 0; i < n; ++i) result.segment_density[i] = charges[i] / (total * contour.length[i] * perimeter);
  for (std::size_t i = 0; i < n; ++i) {
    result.density[i] = 0.5 * (result.segment_density[i] + result.segment_density[(i + n - 1) % n]);
  }
  result.potential = 1.0 / total - 2.0 * std::log(perimeter);
  result.summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace geond
