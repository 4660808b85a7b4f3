// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/image_contour.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace geond::reproduce {
namespace {

using Eigen::Vector2d;

bool Inside(const std::vector<Vector2d>& polygon, const Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vector2d &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

}  // namespace

std::vector<Vector2d> PixelContour(const std::vector<Vector2d>& polygon, double per_unit) {
  Vector2d low = polygon[0], high = low;
  for (const Vector2d& p : polygon) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const int columns = static_cast<int>((high.x() - low.x()) * per_unit) + 5, rows = static_cast<int>((high.y() - low.y()) * per_unit) + 5;
  std::vector<char> full(static_cast<std::size_t>(columns) * rows, 0);
  const auto pixel = [&](int x, int y) { return x >= 0 && y >= 0 && x < columns && y < rows && full[static_cast<std::size_t>(y) * columns + x]; };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      full[static_cast<std::size_t>(y) * columns + x] = Inside(polygon, low + Vector2d(x - 2 + 0.013, y - 2 + 0.007) / per_unit);
    }
  }
  // Moore's walk round the border, counter-clockwise, from the lowest, leftmost pixel.
  constexpr int kX[8] = {1, 1, 0, -1, -1, -1, 0, 1}, kY[8] = {0, 1, 1, 1, 0, -1, -1, -1};
  int x0 = 0, y0 = 0;
  for (y0 = 0; y0 < rows; ++y0) {
    for (x0 = 0; x0 < columns && !pixel(x0, y0); ++x0) {}
    if (x0 < columns) break;
  }
  std::vector<Vector2d> contour;
  int x = x0, y = y0, first_way = -1, way = 0;
  for (std::size_t guard = 0; guard < 8 * full.size(); ++guard) {
    // From just right of where we came, turning left, to the first full pixel.
    int next = -1;
    for (int k = 0; k < 8 && next < 0; ++k) {
      const int d = (way + 6 + k) % 8;  // 90 degrees to the right of the last step first
      if (pixel(x + kX[d], y + kY[d])) next = d;
    }
    if (next < 0) break;
    if (x == x0 && y == y0) {
      if (first_way == next) break;
      if (first_way < 0) first_way = next;
    }
    contour.emplace_back(x, y);
    x += kX[next], y += kY[next];
    way = next;
  }
  // A spike one pixel wide is walked twice; a polygon must not turn back on itself.
  bool changed = true;
  while (changed && contour.size() > 3) {
    changed = false;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      if (contour[i] == contour[(i + 2) % contour.size()]) {
        const std::size_t second = (i + 2) % contour.size(), one = (i + 1) % contour.size();
        contour.erase(contour.begin() + static_cast<std::ptrdiff_t>(std::max(one, second)));
        contour.erase(contour.begin() + static_cast<std::ptrdiff_t>(std::min(one, second)));
        changed = true;
        break;
      }
    }
  }
  return contour;
}

std::vector<Vector2d> LowPass(const std::vector<Vector2d>& contour, double percent) {
  if (!(percent > 0.0)) return contour;
  using Complex = std::complex<double>;
  const int n = static_cast<int>(contour.size());
  std::vector<Complex> turn(n), spectrum(n);
  for (int i = 0; i < n; ++i) turn[i] = std::polar(1.0, 2.0 * std::numbers::pi * i / n);
  for (int k = 0; k < n; ++k) {
    for (int i = 0; i < n; ++i) {
      spectrum[k] += Complex(contour[i].x(), contour[i].y()) * std::conj(turn[static_cast<std::size_t>(static_cast<long>(k) * i % n)]);
    }
  }
  double largest = 0.0;
  for (int k = 1; k < n; ++k) largest = std::max(largest, std::abs(spectrum[k]));
  for (int k = n / 2; k >= 2; --k) {
    if (std::max(std::abs(spectrum[k]), std::abs(spectrum[n - k])) >= 0.01 * percent * largest) break;
    spectrum[k] = spectrum[n - k] = 0.0;
  }
  std::vector<Vector2d> smooth(n);
  for (int i = 0; i < n; ++i) {
    Complex p = 0.0;
    for (int k = 0; k < n; ++k) {
      if (spectrum[k] != 0.0) p += spectrum[k] * turn[static_cast<std::size_t>(static_cast<long>(k) * i % n)];
    }
    smooth[i] = Vector2d(p.real(), p.imag()) / n;
  }
  return smooth;
}

std::vector<double> IncrementalCurvature(const std::vector<Vector2d>& contour) {
  const std::size_t n = contour.size();
  std::vector<double> curvature(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d before = contour[i] - contour[(i + n - 1) % n], after = contour[(i + 1) % n] - contour[i];
    const double turn = std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
    curvature[i] = turn / (0.5 * (before.norm() + after.norm()));
  }
  return curvature;
}

std::vector<double> ArcShare(const std::vector<Vector2d>& contour) {
  std::vector<double> arc{0.0};
  for (std::size_t i = 0; i < contour.size(); ++i) arc.push_back(arc.back() + (contour[(i + 1) % contour.size()] - contour[i]).norm());
  for (double& a : arc) a *= 100.0 / arc.back();
  arc.pop_back();
  return arc;
}

std::vector<int> LocalMaxima(const std::vector<double>& values, int reach) {
  const int n = static_cast<int>(values.size());
  std::vector<int> found;
  for (int i = 0; i < n; ++i) {
    bool greatest = true;
    for (int k = 1; k <= reach && greatest; ++k) {
      // Of equal neighbours the first.
      greatest = values[i] > values[(i + n - k) % n] && values[i] >= values[(i + k) % n];
    }
    if (greatest) found.push_back(i);
  }
  return found;
}

}  // namespace geond::reproduce
