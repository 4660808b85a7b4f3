// SPDX-License-Identifier: Apache-2.0
// Parts that are none of the seven shapes but that a person would call one: bananas (curved cylinders that grow thin at
// the ends), boxes with rounded edges or dents (cuboids), bottles (tapered cylinders).
// fit_imperfect_validation [seed]: noise 0.5 % of the diagonal, from 4 views and, of bananas, from one.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "core/geometry/sample_mesh.h"
#include "core/geon/fit.h"
#include "tests/validation/geon_views.h"

namespace geond {
namespace {

// The geon with every point of its regular surface moved, as points in T.
PointCloud Warped(const Geon& geon, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& warp) {
  TriangleMesh mesh = GeonMesh(geon, 0.04 * geon.size.norm());
  const Pose X_GT = Inverse(geon.X_TG);
  for (Eigen::Vector3d& v : mesh.vertices) v = geon.X_TG * Deform(geon, warp(Undeform(geon, X_GT * v)));
  return SampleMesh(mesh, 20000);
}

struct Tally {
  int right = 0, count = 0;
  double least_margin = 1e300;
};

void Add(Tally& tally, const Geon& geon, const PointCloud& surface, GeonType expected, int views, Draw& draw) {
  ViewOptions options{views, 400, 0.005, 24};
  const double diagonal = DiagonalOf(geon);
  const auto seen_from = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& direction) {
    return Seen(geon, point, direction, diagonal);
  };
  const auto fits = FitGeons(ViewsOfSurface(surface, diagonal, seen_from, options, draw));
  const bool right = fits.front().geon.type == expected;
  tally.right += right;
  ++tally.count;
  if (right) tally.least_margin = std::min(tally.least_margin, fits.front().margin);
  if (!right) {
    std::printf("    %s:", GeonTypeName(fits.front().geon.type).data());
    for (const GeonFit& fit : fits) std::printf(" %d %.4f", static_cast<int>(fit.geon.type), fit.objective / diagonal);
    std::printf("\n");
  }
}

void Print(const char* name, const Tally& tally) {
  std::printf("%-32s right %d of %d, least margin of these %.2f\n", name, tally.right, tally.count, tally.least_margin);
  std::fflush(stdout);
}

int Run(std::uint64_t seed) {
  Draw draw(seed);
  for (const int views : {4, 1}) {
    Tally bananas;
    for (int i = 0; i < 11; ++i) {
      Geon geon = RandomGeon(GeonType::kCurvedCylinder, draw);
      geon.size.y() = geon.size.x() * draw.Uniform(0.9, 1.1);
      geon.size.z() = geon.size.x() * draw.Uniform(2.8, 4.5);
      geon.bend = std::min(draw.Uniform(0.5, 1.1) / geon.size.z(), 0.8 / geon.size.x());
      const double thin = draw.Uniform(0.3, 0.6), power = draw.Uniform(3.0, 5.0);
      const auto warp = [&](const Eigen::Vector3d& p) {
        const double width = 1.0 - thin * std::pow(std::abs(p.z() / geon.size.z()), power);
        return Eigen::Vector3d(width * p.x(), width * p.y(), p.z());
      };
      Add(bananas, geon, Warped(geon, warp), GeonType::kCurvedCylinder, views, draw);
    }
    Print(views == 4 ? "bananas, 4 views" : "bananas, 1 view", bananas);
  }
  Tally boxes;
  for (int i = 0; i < 24; ++i) {
    const Geon geon = RandomGeon(GeonType::kCuboid, draw);
    const double power = draw.Uniform(5.0, 9.0), depth = draw.Uniform(0.02, 0.05) * geon.size.norm();
    const Eigen::Vector3d dent = SampleGeon(geon, 50).points[static_cast<std::size_t>(draw.Uniform(0, 50))];
    const Eigen::Vector3d dent_G = Inverse(geon.X_TG) * dent;
    const auto rounded = [&](const Eigen::Vector3d& p) {  // along the ray to the surface of a lesser exponent
      const double gauge = std::pow((p.array() / geon.size.array()).abs().pow(power).sum(), 1.0 / power);
      return Eigen::Vector3d(p / gauge);
    };
    const auto dented = [&](const Eigen::Vector3d& p) {
      const double r = (p - dent_G).norm() / (0.35 * geon.size.norm());
      return Eigen::Vector3d(p * (1.0 - depth / p.norm() * std::exp(-2.0 * r * r)));
    };
    const PointCloud surface = i % 2 == 0 ? Warped(geon, rounded) : Warped(geon, dented);
    Add(boxes, geon, surface, GeonType::kCuboid, 4, draw);
  }
  Print("rounded and dented boxes, 4 views", boxes);
  Tally bottles;
  for (int i = 0; i < 24; ++i) {
    Geon geon = RandomGeon(GeonType::kCylinder, draw);
    geon.size.y() = geon.size.x();
    geon.size.z() = geon.size.x() * draw.Uniform(1.8, 3.0);
    const double neck = draw.Uniform(0.3, 0.5), shoulder = draw.Uniform(0.1, 0.45), soft = draw.Uniform(0.1, 0.2);
    const auto warp = [&](const Eigen::Vector3d& p) {  // body, shoulder, neck
      const double width = neck + (1.0 - neck) / (1.0 + std::exp((p.z() / geon.size.z() - shoulder) / soft));
      return Eigen::Vector3d(width * p.x(), width * p.y(), p.z());
    };
    Add(bottles, geon, Warped(geon, warp), GeonType::kTaperedCylinder, 4, draw);
  }
  Print("bottles, 4 views", bottles);
  return 0;
}

}  // namespace
}  // namespace geond

int main(int argc, char** argv) { return geond::Run(argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1); }
