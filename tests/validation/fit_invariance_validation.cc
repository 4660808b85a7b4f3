// SPDX-License-Identifier: Apache-2.0
// Whether turning, moving, scaling and shuffling the data changes a fit: fit_invariance_validation [cases] [seed].
// A case: noisy samples of a random geon, and the same with all four done to them. Prints how many types differ, and
// the greatest relative difference of sizes, of positions and of tapers and bends.
#include <cstdio>
#include <cstdlib>
#include <numeric>

#include "core/geon/fit.h"
#include "tests/core/geon/random_geon.h"

namespace geond {
namespace {

int Run(int cases, std::uint64_t seed) {
  Draw draw(seed);
  int other_type = 0, above = 0;
  double size = 0.0, position = 0.0, deformation = 0.0;
  for (int c = 0; c < cases; ++c) {
    const Geon truth = RandomGeon(kGeonTypes[c % 7], draw);
    PointCloud part = SampleGeon(truth, 200);
    const double sigma = 0.01 * 2.0 * truth.size.norm();
    for (std::size_t i = 0; i < part.size(); ++i) {
      part.points[i] += sigma * draw.Normal() * part.normals[i];
      part.normals[i] = (part.normals[i] + 0.08 * draw.Normal3()).normalized();
    }
    const Pose X(draw.Rotation(), draw.Normal3());
    const double factor = std::exp(draw.Uniform(-5.0, 5.0));
    std::vector<int> order(part.size());
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = 0; i + 1 < order.size(); ++i) {
      std::swap(order[i],
                order[i + static_cast<std::size_t>(draw.Uniform(0, 1) * static_cast<double>(order.size() - i))]);
    }
    PointCloud moved = Select(Transform(X, part), order);
    for (Eigen::Vector3d& p : moved.points) p *= factor;
    const Geon a = FitGeons(part).front().geon, b = FitGeons(moved).front().geon;
    if (a.type != b.type) {
      ++other_type;
      continue;
    }
    const double scale = a.size.norm();
    const double of_size = (b.size / factor - a.size).norm() / scale;
    const double of_position =
        (Inverse(X) * Eigen::Vector3d(b.X_TG.translation() / factor) - a.X_TG.translation()).norm() / scale;
    const double of_deformation = std::max((a.taper - b.taper).norm(), std::abs(b.bend * factor - a.bend) * scale);
    size = std::max(size, of_size);
    position = std::max(position, of_position);
    deformation = std::max(deformation, of_deformation);
    if (std::max({of_size, of_position, of_deformation}) > 1e-6) {
      ++above;
      std::printf("case %d, %s: size %.1e position %.1e deformation %.1e\n", c, GeonTypeName(a.type).data(), of_size,
                  of_position, of_deformation);
    }
  }
  std::printf("%d cases: another type %d, above 1e-6 %d; greatest: size %.1e position %.1e taper or bend %.1e\n", cases,
              other_type, above, size, position, deformation);
  return 0;
}

}  // namespace
}  // namespace geond

int main(int argc, char** argv) {
  return geond::Run(argc > 1 ? std::atoi(argv[1]) : 1000, argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
}
