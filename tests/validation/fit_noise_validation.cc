// SPDX-License-Identifier: Apache-2.0
// Types and parameters found in range data of random geons under noise: fit_noise_validation [geons a type] [seed].
// Sizes pooled over the three of a geon, relative; position over D, the geon's diagonal; axis the angle of G's z axis.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include "core/geon/fit.h"
#include "core/geon/misfit.h"
#include "core/geon/objective.h"
#include "tests/validation/geon_views.h"

namespace {

using namespace geond;

struct Condition {
  const char* name;
  ViewOptions views;
};

double Quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0.0;
  std::sort(v.begin(), v.end());
  return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}

struct Errors {
  std::vector<double> size, position, axis;
  std::vector<double> whole_position;      // of geons of which every size has a deviation: all their ends were found
  int inside = 0, finite = 0, sizes = 0;   // sizes within 1.96 deviations of the truth, of those that have one
};

void AddErrors(const Geon& truth, const GeonFit& fit, double diagonal, Errors& errors) {
  const Geon& found = fit.geon;
  Eigen::Vector3d size = found.size;
  Eigen::Vector3d deviation(fit.deviation[6], fit.deviation[7], fit.deviation[8]);
  // Which axis is called x is a matter of sizes: of the orders that the type allows, the one whose axes agree best.
  const Eigen::Matrix3d cosine = (truth.X_TG.matrix().transpose() * found.X_TG.matrix()).cwiseAbs();
  const bool any_axis = truth.type == GeonType::kCuboid || truth.type == GeonType::kEllipsoid;
  std::array<int, 3> order{0, 1, 2}, best = order;
  double agreement = -1.0;
  do {
    if ((!any_axis && order[2] != 2) || (IsCurved(truth.type) && order[0] != 0)) continue;
    const double sum = cosine(0, order[0]) + cosine(1, order[1]) + cosine(2, order[2]);
    if (sum > agreement + 1e-9) {
      agreement = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  const Eigen::Vector3d found_size = size, found_deviation = deviation;
  for (int k = 0; k < 3; ++k) {
    size[k] = found_size[best[k]];
    deviation[k] = found_deviation[best[k]];
  }
  bool whole = true;
  for (int k = 0; k < 3; ++k) {
    whole = whole && std::isfinite(deviation[k]);
    errors.size.push_back(std::abs(size[k] / truth.size[k] - 1.0));
    ++errors.sizes;
    if (!std::isfinite(deviation[k])) continue;
    ++errors.finite;
    if (std::getenv("SHOW_SIZES")) {
      std::printf("  type %d size %d: %.4f, true %.4f, deviation %.4f\n", static_cast<int>(truth.type), k, size[k], truth.size[k],
                  deviation[k]);
    }
    errors.inside += std::abs(size[k] - truth.size[k]) <= 1.96 * deviation[k] + 1e-9 * truth.size[k];
  }
  errors.position.push_back((found.X_TG.translation() - truth.X_TG.translation()).norm() / diagonal);
  if (whole) errors.whole_position.push_back(errors.position.back());
  const double along = any_axis ? cosine.col(2).maxCoeff() : cosine(2, 2);
  errors.axis.push_back(std::acos(std::min(1.0, along)) * 180.0 / std::numbers::pi);
}

}  // namespace

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 20;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const char* only = argc > 3 ? argv[3] : "";
  const Condition conditions[] = {
      {"0, 4 views", {4, 400, 0.0}},          {"0.5 %, 4 views", {4, 400, 0.005, 24}},
      {"1 %, 4 views", {4, 400, 0.01, 40}},   {"2 %, 4 views", {4, 400, 0.02, 80}},
      {"1 %, 1 view", {1, 400, 0.01, 40}},    {"1 %, 4 views, 20 % outliers", {4, 400, 0.01, 40, 2500, 0.2}},
  };
  for (const Condition& condition : conditions) {
    if (std::string(condition.name).find(only) == std::string::npos) continue;
    Errors errors;
    int right = 0, total = 0, missed = 0;
    int table[8][8] = {};
    double t2 = 0.0, outliers = 0.0;
    const std::clock_t begin = std::clock();
    double fitting = 0.0;
    for (const GeonType type : kGeonTypes) {
      Draw draw(seed * 1000 + static_cast<std::uint64_t>(type));
      for (int i = 0; i < count; ++i) {
        Geon truth = RandomGeon(type, draw);
        if (i % 2 == 0 && BaseType(type) == GeonType::kCylinder && !IsCurved(type)) {   // half of them of revolution
          truth.size.y() = truth.size.x();
          truth.taper.y() = truth.taper.x();
        }
        truth = Canonical(truth);
        const PointCloud part = ViewsOfGeon(truth, condition.views, draw);
        FitOptions options;
        options.threads = 1;
        const std::clock_t start = std::clock();
        const auto fits = FitGeons(part, options);
        fitting += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        const Geon& found = fits.front().geon;
        ++total;
        right += found.type == type;
        if (found.type != type && std::getenv("SHOW")) {
          std::printf("  %d-%d:", static_cast<int>(type), i);
          for (const GeonFit& fit : fits) std::printf(" %d %.4f", static_cast<int>(fit.geon.type), fit.objective / DiagonalOf(truth));
          std::printf("  (truth %.4f)\n", EvaluateObjective(truth, part, 5.0).value / DiagonalOf(truth));
        }
        ++table[static_cast<int>(type)][static_cast<int>(found.type)];
        const Objective at_truth = EvaluateObjective(truth, part, 5.0);
        t2 += at_truth.t2;
        outliers += fits.front().outliers;
        for (const GeonFit& fit : fits) {
          if (fit.geon.type != type) continue;
          missed += fit.objective > 1.001 * at_truth.value + 1e-9;
          AddErrors(truth, fit, DiagonalOf(truth), errors);
        }
      }
    }
    std::printf("%-28s right %4d of %4d (%.1f %%)  own type above truth %d  size %.5f | %.4f  position/D %.5f | %.4f  "
                "axis %.3f | %.2f deg  (t2 of truth %.4f, outliers %.1f, %.1f ms a fit, %.0f s)\n",
                condition.name, right, total, 100.0 * right / total, missed, Quantile(errors.size, 0.5),
                Quantile(errors.size, 0.9), Quantile(errors.position, 0.5), Quantile(errors.position, 0.9),
                Quantile(errors.axis, 0.5), Quantile(errors.axis, 0.9), t2 / total, outliers / total, 1e3 * fitting / total,
                static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    std::printf("    sizes with a deviation %.0f %%, of these within 1.96 of it %.1f %%; position/D where all have one %.5f | %.4f\n",
                100.0 * errors.finite / errors.sizes, 100.0 * errors.inside / std::max(1, errors.finite),
                Quantile(errors.whole_position, 0.5), Quantile(errors.whole_position, 0.9));
    for (int t = 1; t <= 7; ++t) {
      for (int f = 1; f <= 7; ++f) {
        if (t != f && table[t][f]) std::printf("    %d of %d taken for %d\n", table[t][f], t, f);
      }
    }
    std::fflush(stdout);
  }
}
