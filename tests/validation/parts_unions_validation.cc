// SPDX-License-Identifier: Apache-2.0
// Parts of random unions of solids: number found and Rand index, clean and with noise of 0.5 % of the diagonal.
// Usage: parts_unions_validation [objects=100] [first seed=5000] [triangles=2500] [--list]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/parts/segment.h"
#include "tests/core/parts/segmentation_case.h"
#include "tests/validation/random_union.h"

using namespace geond;

int main(int argc, char** argv) {
  const bool list = argc > 1 && std::strcmp(argv[argc - 1], "--list") == 0;
  const int objects = argc > 1 && std::atoi(argv[1]) > 0 ? std::atoi(argv[1]) : 100;
  const int seed = argc > 2 && std::atoi(argv[2]) > 0 ? std::atoi(argv[2]) : 5000;
  const int triangles = argc > 3 && std::atoi(argv[3]) > 0 ? std::atoi(argv[3]) : 2500;
  constexpr double kNoises[] = {0.0, 0.005};
  int right[2][6] = {}, count[6] = {};
  double rand[2][6] = {};
  const std::clock_t start = std::clock();
  for (int i = 0; i < objects; ++i) {
    const int n_parts = 1 + i % 5;
    const test::UnionObject object = test::RandomUnion(n_parts, seed + i, triangles);
    if (object.mesh.empty()) {
      std::printf("no object of %d parts from seed %d\n", n_parts, seed + i);
      continue;
    }
    ++count[n_parts];
    for (int k = 0; k < 2; ++k) {
      const TriangleMesh mesh = test::WithNoise(object.mesh, kNoises[k] * test::BoxDiagonal(object.mesh),
                                                static_cast<std::uint64_t>(seed + i));
      const PartSegmentation found = SegmentParts(mesh, SolveChargeDensity(mesh));
      const double index = test::RandIndex(found.labels, object.labels);
      right[k][n_parts] += found.n_parts == n_parts;
      rand[k][n_parts] += index;
      if (list && (found.n_parts != n_parts || index < 0.9)) {
        std::printf("seed %d noise %.3f: %d of %d, Rand %.3f\n", seed + i, kNoises[k], found.n_parts, n_parts, index);
        std::fflush(stdout);
      }
    }
  }
  for (int k = 0; k < 2; ++k) {
    int all = 0, n = 0;
    double sum = 0.0;
    std::printf("noise %.1f %%:", 100.0 * kNoises[k]);
    for (int p = 1; p <= 5; ++p) {
      std::printf("  %d parts %d/%d (%.3f)", p, right[k][p], count[p], count[p] ? rand[k][p] / count[p] : 0.0);
      all += right[k][p];
      n += count[p];
      sum += rand[k][p];
    }
    std::printf("  all %d/%d, Rand %.3f\n", all, n, n ? sum / n : 0.0);
  }
  std::printf("CPU seconds %.0f\n", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  return 0;
}
