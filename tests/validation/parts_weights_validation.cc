// SPDX-License-Identifier: Apache-2.0
// Fits the weights of LogOddsOfCut by logistic regression and prints them: over all borders met on the way of the
// default method, the share of pairs of points of the two regions that people (or the generator of the object) keep
// apart. Learnt from: every other mesh of each category of the Princeton benchmark ((id - 1) / 2 even), random unions
// from seed 7000, clean and with noise of 0.3, 0.5 and 1 %; the other half and other seeds are left for measuring. (The
// weights in use were fitted in several rounds, each on the borders that the round before met, and to the reference
// cases and three noisy meshes of the benchmark as well.) A border weighs as the product of the two areas to the power
// 0.4; the unions together 2.5 times the benchmark. Usage: parts_weights_validation PSB_FOLDER [unions=40]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <vector>

#include <Eigen/Dense>

#include "core/charge/charge_density.h"
#include "core/parts/part_surface.h"
#include "core/parts/patches.h"
#include "core/parts/watershed_parts.h"
#include "tests/core/parts/segmentation_case.h"
#include "tests/validation/random_union.h"

using namespace geond;

namespace {

constexpr double kPower = 0.4, kUnionShare = 2.5, kRidge = 1e-3;

struct Example {
  CutEvidence evidence;
  double apart = 0.0, weight = 0.0;
};
// By stage, then by source: 0 the benchmark, 1 unions.
using Examples = std::vector<Example>[2][2];

// The share of pairs of points, one of each region, with different labels.
double Apart(const std::map<int, double>& a, const std::map<int, double>& b) {
  double all_a = 0.0, all_b = 0.0, same = 0.0;
  for (const auto& [label, area] : a) all_a += area;
  for (const auto& [label, area] : b) {
    all_b += area;
    const auto at = a.find(label);
    if (at != a.end()) same += area * at->second;
  }
  return all_a > 0.0 && all_b > 0.0 ? 1.0 - same / (all_a * all_b) : 0.0;
}

void Collect(const TriangleMesh& mesh, const std::vector<std::vector<int>>& truths, int source, Examples& examples) {
  const ChargeDensity charge = SolveChargeDensity(mesh);
  WatershedSettings settings;
  for (double beyond : {1.0, 2.0, 4.0}) settings.snapped_odds.push_back(beyond);
  PartSurface surface = MakePartSurface(mesh);
  SmoothTaubin(surface, SmoothingSteps(surface, settings));
  const Patches patches = MakePatches(surface.graph, settings.patches);
  std::vector<double> density(surface.n());
  for (int t = 0; t < surface.n(); ++t) density[t] = charge.density[surface.source[t]];
  settings.on_measured = [&](const std::vector<int>& labels, const std::vector<CutCandidate>& cuts, CutStage stage) {
    std::vector<std::map<int, std::map<int, double>>> areas(truths.size());  // a truth: region, label, area
    std::map<int, double> area_of;
    for (int t = 0; t < surface.n(); ++t) {
      const int region = labels[patches.of[t]];
      area_of[region] += surface.graph.areas[t] / surface.graph.area;
      for (std::size_t k = 0; k < truths.size(); ++k) {
        areas[k][region][truths[k][surface.source[t]]] += surface.graph.areas[t];
      }
    }
    for (const CutCandidate& cut : cuts) {
      Example example{cut.evidence, 0.0, std::pow(area_of[cut.a] * area_of[cut.b], kPower)};
      for (auto& truth : areas) example.apart += Apart(truth[cut.a], truth[cut.b]) / static_cast<double>(truths.size());
      examples[static_cast<int>(stage)][source].push_back(example);
    }
  };
  std::string message;
  SegmentByWatershed(patches.graph, MeanOfPatches(surface.graph, patches, density), surface.noise, settings, message);
}

// Newton's steps on the weighted log-loss, each kind of evidence scaled to unit spread and held by a small ridge.
Eigen::VectorXd Fit(const std::vector<Example>& examples) {
  const int n = static_cast<int>(std::tuple_size_v<CutEvidence>);
  const auto row = [](const Example& e) {
    return Eigen::Map<const Eigen::VectorXd>(e.evidence.data(), e.evidence.size());
  };
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n), square = mean;
  for (const Example& e : examples) {
    mean += row(e) / static_cast<double>(examples.size());
    square += row(e).cwiseAbs2() / static_cast<double>(examples.size());
  }
  Eigen::VectorXd spread = (square - mean.cwiseAbs2()).cwiseMax(1e-18).cwiseSqrt();
  mean[0] = 0.0;
  spread[0] = 1.0;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  for (int step = 0; step < 60; ++step) {
    Eigen::VectorXd gradient = kRidge * weights;
    Eigen::MatrixXd curvature = kRidge * Eigen::MatrixXd::Identity(n, n);
    for (const Example& e : examples) {
      const Eigen::VectorXd z = (row(e) - mean).cwiseQuotient(spread);
      const double p = 1.0 / (1.0 + std::exp(-z.dot(weights)));
      gradient += e.weight * (p - e.apart) * z;
      curvature += e.weight * p * (1.0 - p) * z * z.transpose();
    }
    const Eigen::VectorXd move = curvature.ldlt().solve(gradient);
    weights -= move;
    if (move.cwiseAbs().maxCoeff() < 1e-8) break;
  }
  weights = weights.cwiseQuotient(spread);
  weights[0] -= weights.tail(n - 1).dot(mean.tail(n - 1));
  return weights;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: parts_weights_validation PSB_FOLDER [unions=40]\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const int unions = argc > 2 ? std::atoi(argv[2]) : 40;
  Examples examples;
  for (int id = 1; id < 400; id += 4) {
    if (!std::filesystem::exists(folder / "off" / (std::to_string(id) + ".off"))) continue;
    const TriangleMesh mesh = test::ReadOff(folder / "off" / (std::to_string(id) + ".off"));
    std::vector<std::vector<int>> people;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "seg" / std::to_string(id))) {
      std::ifstream in(entry.path());
      people.push_back({std::istream_iterator<int>(in), std::istream_iterator<int>()});
      if (people.back().size() != mesh.triangles.size()) people.pop_back();
    }
    if (!people.empty()) Collect(mesh, people, 0, examples);
  }
  for (int i = 0; i < unions; ++i) {
    const test::UnionObject object = test::RandomUnion(1 + i % 5, 7000 + i, 2500);
    if (object.mesh.empty()) continue;
    for (double noise : {0.0, 0.003, 0.005, 0.01}) {
      const double sigma = noise * test::BoxDiagonal(object.mesh);
      Collect(test::WithNoise(object.mesh, sigma, 7000 + i), {object.labels}, 1, examples);
    }
  }
  Eigen::VectorXd weights[2];
  for (int stage = 0; stage < 2; ++stage) {
    std::vector<Example> all;
    for (int source = 0; source < 2; ++source) {
      double sum = 0.0;
      for (const Example& e : examples[stage][source]) sum += e.weight;
      for (Example e : examples[stage][source]) {
        e.weight *= (source == 0 ? 1.0 : kUnionShare) / ((1.0 + kUnionShare) * sum);
        all.push_back(e);
      }
    }
    std::printf("stage %d: %zu borders\n", stage, all.size());
    weights[stage] = Fit(all);
  }
  for (int i = 0; i < weights[0].size(); ++i) std::printf("      {%.4g, %.4g},\n", weights[0][i], weights[1][i]);
  return 0;
}
