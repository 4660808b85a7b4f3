// SPDX-License-Identifier: Apache-2.0
// The charge of contours against time: ellipses and outlines of pixels of growing size, CPU seconds over all threads
// and the wall's. Usage: charge_contour_bench [largest number of segments, 100000].
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <vector>

#include "core/charge/contour.h"

namespace {

using namespace geond;

double CpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Solve(const char* name, const std::vector<Eigen::Vector2d>& polygon) {
  const double cpu = CpuSeconds();
  const auto start = std::chrono::steady_clock::now();
  const ContourDensity charge = SolveContourCharge(polygon);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%-8s %8zu  %8.4f CPU s  %8.4f s  %3d iterations  error <= %.1e  residual %.1e\n", name, polygon.size(),
              CpuSeconds() - cpu, wall, charge.summary.iterations, charge.error_estimate, charge.summary.residual);
  std::fflush(stdout);
}

std::vector<Eigen::Vector2d> Ellipse(int n) {
  std::vector<Eigen::Vector2d> polygon;
  for (int i = 0; i < n; ++i) {
    const double t = 2.0 * std::numbers::pi * i / n;
    polygon.emplace_back(2.0 * std::cos(t), std::sin(t));
  }
  return polygon;
}

// Centres of the pixels along a five-lobed curve.
std::vector<Eigen::Vector2d> Pixels(double size) {
  std::vector<Eigen::Vector2d> polygon;
  const int steps = static_cast<int>(40 * size);
  for (int i = 0; i < steps; ++i) {
    const double t = 2.0 * std::numbers::pi * i / steps, r = size * (1.0 + 0.3 * std::cos(5.0 * t));
    const Eigen::Vector2d p(std::round(r * std::cos(t)), std::round(0.7 * r * std::sin(t)));
    if (polygon.empty() || p != polygon.back()) polygon.push_back(p);
  }
  if (polygon.front() == polygon.back()) polygon.pop_back();
  return polygon;
}

}  // namespace

int main(int argc, char** argv) {
  const int largest = argc > 1 ? std::atoi(argv[1]) : 100000;
  for (int n = 1000; n <= largest; n *= 10) {
    Solve("ellipse", Ellipse(n));
    Solve("pixels", Pixels(0.157 * n));
  }
}
