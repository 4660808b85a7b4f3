// SPDX-License-Identifier: Apache-2.0
#include "core/charge/contour_potential.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/progress.h"

// A cell's multipoles a_0 ln(z - c) + sum over k of a_k (radius/(z - c))^k and local terms sum of b_l ((z -
// c)/radius)^l are taken in lengths of its radius, so that nothing overflows. The potential is -2 times the real part.
namespace geond::charge {
namespace {

using Complex = std::complex<double>;
constexpr std::ptrdiff_t kLeaf = 24;  // segments
constexpr double kTheta = 0.6;

// A product without the care for infinities that the language prescribes.
inline Complex Times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace

double SegmentPotential(const Contour& contour, std::ptrdiff_t k, Complex z) {
  // With l the place along the segment's line and P the distance from it, the primitive of ln R is l ln R - l + P
  // atan(l/P).
  const Complex to_a = contour.vertex[k] - z, side = contour.end(k) - contour.vertex[k];
  const double length = contour.length[k];
  const Complex turned = Times(to_a, std::conj(side)) / length;
  const double l_minus = turned.real(), l_plus = l_minus + length, P = std::abs(turned.imag());
  const auto l_log = [&](double l) {
    const double R_squared = l * l + P * P;
    return R_squared == 0.0 ? 0.0 : 0.5 * l * std::log(R_squared);
  };
  const double angle = std::atan2(P * length, P * P + l_minus * l_plus);
  return -2.0 * (l_log(l_plus) - l_log(l_minus) - length + P * angle) / length;
}

ContourPotential::ContourPotential(const Contour& contour, int order, int threads, const std::stop_token& stop)
    : contour_(contour),
      order_(order),
      threads_(threads),
      choose_(Eigen::MatrixXd::Zero(2 * order + 1, 2 * order + 1)),
      across_(Eigen::MatrixXd::Zero(order, order)) {
  for (int n = 0; n <= 2 * order; ++n) {
    choose_(n, 0) = 1.0;
    for (int k = 1; k <= n; ++k) choose_(n, k) = choose_(n - 1, k - 1) + (k < n ? choose_(n - 1, k) : 0.0);
  }
  for (int l = 1; l <= order; ++l) {
    for (int k = 1; k <= order; ++k) across_(l - 1, k - 1) = choose_(l + k - 1, k - 1);
  }
  MakeCells();
  FindPairs();
  MakeNear(stop);
}

void ContourPotential::MakeCells() {
  cells_.push_back({0, contour_.size()});
  level_begin_ = {0};
  while (level_begin_.back() < static_cast<int>(cells_.size())) {
    const int first = level_begin_.back(), last = static_cast<int>(cells_.size());
    level_begin_.push_back(last);
    for (int c = first; c < last; ++c) {
      const Cell cell = cells_[c];
      if (cell.count() <= kLeaf) continue;
      const std::ptrdiff_t middle = cell.begin + cell.count() / 2;
      cells_[c].child = static_cast<int>(cells_.size());
      cells_.push_back({cell.begin, middle, c});
      cells_.push_back({middle, cell.end, c});
    }
  }
  ParallelFor(static_cast<std::ptrdiff_t>(cells_.size()), threads_, 16, [&](std::ptrdiff_t c) {
    Cell& cell = cells_[c];
    const Complex first = contour_.vertex[cell.begin];
    double left = first.real(), right = left, low = first.imag(), high = low;
    for (std::ptrdiff_t k = cell.begin; k < cell.end; ++k) {
      const Complex v = contour_.end(k);
      left = std::min(left, v.real()), right = std::max(right, v.real());
      low = std::min(low, v.imag()), high = std::max(high, v.imag());
    }
    cell.centre = {0.5 * (left + right), 0.5 * (low + high)};
    double reach = std::norm(first - cell.centre);
    for (std::ptrdiff_t k = cell.begin; k < cell.end; ++k)
      reach = std::max(reach, std::norm(contour_.end(k) - cell.centre));
    cell.radius = std::sqrt(reach);
  });
}

void ContourPotential::FindPairs() {
  std::vector<std::pair<int, int>> near, far, open = {{0, 0}};
  while (!open.empty()) {
    const auto [target, source] = open.back();
    open.pop_back();
    const Cell &A = cells_[target], &B = cells_[source];
    if (A.radius + B.radius < kTheta * std::abs(A.centre - B.centre)) {
      far.emplace_back(target, source);
    } else if (A.child < 0 && B.child < 0) {
      near.emplace_back(target, source);
    } else if (B.child < 0 || (A.child >= 0 && A.radius >= B.radius)) {
      open.insert(open.end(), {{A.child, source}, {A.child + 1, source}});
    } else {
      open.insert(open.end(), {{target, B.child}, {target, B.child + 1}});
    }
  }
  near_ = SortByTarget(near, cells_.size(), threads_);
  far_ = SortByTarget(far, cells_.size(), threads_);
}

void ContourPotential::MakeNear(const std::stop_token& stop) {
  std::size_t total = 0;
  for (std::size_t target = 0; target < cells_.size(); ++target) {
    for (std::size_t pair = near_.begin[target]; pair < near_.begin[target + 1]; ++pair) {
      near_begin_.push_back(total);
      total += cells_[target].count() * cells_[near_.source[pair]].count();
    }
  }
  near_values_.resize(total);
  ParallelFor(static_cast<std::ptrdiff_t>(cells_.size()), threads_, 16, [&](std::ptrdiff_t t) {
    ThrowIfStopped(stop);
    const Cell& target = cells_[t];
    for (std::size_t pair = near_.begin[t]; pair < near_.begin[t + 1]; ++pair) {
      const Cell& source = cells_[near_.source[pair]];
      double* value = &near_values_[near_begin_[pair]];
      for (std::ptrdiff_t k = source.begin; k < source.end; ++k) {
        for (std::ptrdiff_t i = target.begin; i < target.end; ++i) {
          *value++ = SegmentPotential(contour_, k, contour_.middle(i));
        }
      }
    }
  });
}

void ContourPotential::Gather(std::span<const double> charge, std::vector<Complex>& multipoles) const {
  const std::size_t terms = order_ + 1;
  for (int level = static_cast<int>(level_begin_.size()) - 2; level >= 0; --level) {
    const int first = level_begin_[level], count = level_begin_[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 64, [&](std::ptrdiff_t i) {
      const Cell& cell = cells_[first + i];
      Complex* const a = &multipoles[(first + i) * terms];
      if (cell.child >= 0) {
        ShiftUp(cells_[cell.child], &multipoles[cell.child * terms], cell, a);
        ShiftUp(cells_[cell.child + 1], &multipoles[(cell.child + 1) * terms], cell, a);
        return;
      }
      // The mean of w^k from w = A to B is (A^k + A^(k-1) B + ... + B^k)/(k + 1).
      for (std::ptrdiff_t k = cell.begin; k < cell.end; ++k) {
        const Complex A = (contour_.vertex[k] - cell.centre) / cell.radius,
                      B = (contour_.end(k) - cell.centre) / cell.radius;
        Complex power = A, sum = A + B;
        a[0] += charge[k];
        for (int n = 1; n <= order_; ++n) {
          a[n] -= charge[k] / (n * (n + 1.0)) * sum;
          power = Times(power, A);
          sum = Times(sum, B) + power;
        }
      }
    });
  }
}

void ContourPotential::ShiftUp(const Cell& from, const Complex* child, const Cell& to, Complex* parent) const {
  const Complex shift = (from.centre - to.centre) / to.radius;
  const double shrink = from.radius / to.radius;
  // Horner by powers of the shift, one term of the child after another.
  std::vector<Complex> powers(order_ + 1, 1.0);
  for (int n = 1; n <= order_; ++n) powers[n] = Times(powers[n - 1], shift);
  double scale = 1.0;
  parent[0] += child[0];
  for (int l = 1; l <= order_; ++l) parent[l] -= child[0] / static_cast<double>(l) * powers[l];
  for (int k = 1; k <= order_; ++k) {
    scale *= shrink;
    const Complex scaled = scale * child[k];
    for (int l = k; l <= order_; ++l) parent[l] += choose_(l - 1, k - 1) * Times(scaled, powers[l - k]);
  }
}

void ContourPotential::Across(int target, const std::vector<Complex>& multipoles, Complex* local) const {
  const Cell& cell = cells_[target];
  const std::size_t first = far_.begin[target];
  const auto count = static_cast<Eigen::Index>(far_.begin[target + 1] - first);
  if (count == 0) return;
  Eigen::MatrixXd X(order_, 2 * count);
  std::vector<Complex> inverse(count);
  for (Eigen::Index j = 0; j < count; ++j) {
    const int s = far_.source[first + j];
    const Complex* const a = &multipoles[s * (order_ + 1)];
    const Complex apart = cells_[s].centre - cell.centre;
    inverse[j] = 1.0 / apart;
    const Complex ratio = -cells_[s].radius * inverse[j];
    Complex power = ratio;
    local[0] += a[0].real() * std::log(-apart);
    for (int k = 1; k <= order_; ++k) {
      const Complex term = Times(a[k], power);
      local[0] += term;
      X(k - 1, 2 * j) = term.real(), X(k - 1, 2 * j + 1) = term.imag();
      power = Times(power, ratio);
    }
  }
  const Eigen::MatrixXd Y = across_ * X;
  for (Eigen::Index j = 0; j < count; ++j) {
    const double charge = multipoles[far_.source[first + j] * (order_ + 1)].real();
    const Complex ratio = cell.radius * inverse[j];
    Complex power = ratio;
    for (int l = 1; l <= order_; ++l) {
      local[l] += Times(power, Complex(Y(l - 1, 2 * j) - charge / l, Y(l - 1, 2 * j + 1)));
      power = Times(power, ratio);
    }
  }
}

void ContourPotential::ShiftDown(const Cell& from, const Complex* parent, const Cell& to, Complex* child) const {
  const Complex shift = (to.centre - from.centre) / from.radius;
  const double shrink = to.radius / from.radius;
  std::vector<Complex> powers(order_ + 1, 1.0);
  for (int n = 1; n <= order_; ++n) powers[n] = Times(powers[n - 1], shift);
  double scale = 1.0;
  for (int l = 0; l <= order_; ++l) {
    Complex sum = 0.0;
    for (int k = l; k <= order_; ++k) sum += choose_(k, l) * Times(parent[k], powers[k - l]);
    child[l] += scale * sum;
    scale *= shrink;
  }
}

void ContourPotential::Apply(std::span<const double> charge, std::span<double> potential) const {
  const std::size_t terms = order_ + 1;
  std::vector<Complex> multipoles(cells_.size() * terms), locals(cells_.size() * terms);
  Gather(charge, multipoles);
  ParallelFor(static_cast<std::ptrdiff_t>(cells_.size()), threads_, 32,
              [&](std::ptrdiff_t c) { Across(static_cast<int>(c), multipoles, &locals[c * terms]); });
  for (std::size_t level = 0; level + 1 < level_begin_.size(); ++level) {
    const int first = level_begin_[level], count = level_begin_[level + 1] - first;
    ParallelFor(count, count < 64 ? 1 : threads_, 64, [&](std::ptrdiff_t i) {
      const int c = first + static_cast<int>(i);
      const Cell& cell = cells_[c];
      Complex* const b = &locals[c * terms];
      if (cell.parent >= 0) ShiftDown(cells_[cell.parent], &locals[cell.parent * terms], cell, b);
      if (cell.child >= 0) return;
      Eigen::Map<Eigen::VectorXd> out(&potential[cell.begin], cell.count());
      for (std::ptrdiff_t k = cell.begin; k < cell.end; ++k) {
        const Complex place = (contour_.middle(k) - cell.centre) / cell.radius;
        Complex sum = b[order_];
        for (int l = order_ - 1; l >= 0; --l) sum = Times(sum, place) + b[l];
        potential[k] = -2.0 * sum.real();
      }
      for (std::size_t pair = near_.begin[c]; pair < near_.begin[c + 1]; ++pair) {
        const Cell& source = cells_[near_.source[pair]];
        const Eigen::Map<const Eigen::MatrixXd> block(&near_values_[near_begin_[pair]], cell.count(), source.count());
        out.noalias() += block * Eigen::Map<const Eigen::VectorXd>(&charge[source.begin], source.count());
      }
    });
  }
}

}  // namespace geond::charge
