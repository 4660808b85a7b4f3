// SPDX-License-Identifier: Apache-2.0
#include "core/charge/potential_spread.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/base/parallel.h"
#include "core/charge/kernels.h"
#include "core/charge/panels.h"

namespace geond {

PotentialSpreadResult PotentialSpread(const TriangleMesh& mesh, const ChargeDensity& charge, std::uint64_t seed,
                                      int samples) {
  if (charge.density.size() != mesh.triangles.size() || mesh.empty()) {
    throw std::invalid_argument("the charge density has " + std::to_string(charge.density.size()) +
                                " values, the mesh " + std::to_string(mesh.triangles.size()) + " triangles");
  }
  if (samples < 1) throw std::invalid_argument("the spread of the potential needs one sample or more");

  std::vector<double> reach = TriangleAreas(mesh);  // area of all triangles up to and with this one
  for (std::size_t i = 1; i < reach.size(); ++i) reach[i] += reach[i - 1];
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<double> x(samples), y(samples), z(samples), potential(samples, 0.0);
  for (int i = 0; i < samples; ++i) {
    const auto found = std::upper_bound(reach.begin(), reach.end(), uniform() * reach.back());
    const auto triangle =
        std::min<std::ptrdiff_t>(found - reach.begin(), static_cast<std::ptrdiff_t>(reach.size()) - 1);
    const auto& [a, b, c] = mesh.triangles[triangle];
    const double root = std::sqrt(uniform()), v = uniform();
    const Eigen::Vector3d p =
        (1.0 - root) * mesh.vertices[a] + root * (1.0 - v) * mesh.vertices[b] + root * v * mesh.vertices[c];
    x[i] = p.x(), y[i] = p.y(), z[i] = p.z();
  }

  constexpr int kBlock = 64;
  const charge::Kernels& kernels = charge::BestKernels();
  ParallelFor((samples + kBlock - 1) / kBlock, 0, 1, [&](std::ptrdiff_t block) {
    const auto begin = static_cast<int>(block) * kBlock;
    const int count = std::min(kBlock, samples - begin);
    double integral[kBlock];
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
      kernels.double_precision.triangle_potential(charge::FrameOf(mesh, k), &x[begin], &y[begin], &z[begin], count,
                                                  integral);
      for (int i = 0; i < count; ++i) potential[begin + i] += charge.density[k] * integral[i];
    }
  });

  PotentialSpreadResult result;
  result.samples = samples;
  for (double value : potential) result.mean += value / samples;
  double squares = 0.0;
  for (double value : potential) squares += (value - result.mean) * (value - result.mean);
  result.relative_rms = std::sqrt(squares / samples) / std::abs(result.mean);
  const auto [least, most] = std::minmax_element(potential.begin(), potential.end());
  result.least = *least, result.most = *most;
  return result;
}

}  // namespace geond
