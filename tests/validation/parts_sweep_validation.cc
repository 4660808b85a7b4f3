// SPDX-License-Identifier: Apache-2.0
// How parts hold under sampling and noise.
// Usage: parts_sweep_validation remesh [triangles...]   the clean cases remeshed at 500, 6000, 24000 triangles
//        parts_sweep_validation noise [share...]        the clean cases of 3000 triangles with 0.003 and 0.01 of the
//                                                       diagonal as noise
//        parts_sweep_validation psb FOLDER              teddy 161, ant 81, octopus 125 with noise of 0, 0.2, 0.5 %,
//                                                       five draws each: mean and worst
//        parts_sweep_validation turn                    renumbered and turned: how far the index moves
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/parts/segment.h"
#include "core/surface/remesh.h"
#include "tests/core/parts/segmentation_case.h"

using namespace geond;

namespace {

const std::filesystem::path& Cases() {
  static const std::filesystem::path folder =
      std::filesystem::path(std::getenv("GEOND_CASES") ? std::getenv("GEOND_CASES")
                                                       : GEOND_SOURCE_DIR "/../shared/cases") /
      "segmentation";
  return folder;
}

std::vector<std::string> CleanCases() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(Cases())) {
    const std::string name = entry.path().stem();
    if (entry.path().extension() == ".json" && name.starts_with("clean3000_")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

// For each triangle the label of the nearest triangle of another mesh of the same surface.
std::vector<int> CarryLabels(const TriangleMesh& from, const std::vector<int>& labels, const TriangleMesh& to) {
  std::vector<Eigen::Vector3d> centroids;
  for (int t = 0; t < static_cast<int>(from.triangles.size()); ++t) centroids.push_back(TriangleCentroid(from, t));
  std::vector<int> carried(to.triangles.size());
  for (std::size_t t = 0; t < carried.size(); ++t) {
    const Eigen::Vector3d x = TriangleCentroid(to, static_cast<int>(t));
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < centroids.size(); ++k) {
      const double d = (centroids[k] - x).squaredNorm();
      if (d < best) best = d, carried[t] = labels[k];
    }
  }
  return carried;
}

struct Tally {
  int right[3] = {}, count[3] = {};  // closed, open, single
  double rand[3] = {};
  void Add(const std::string& name, int true_parts, int found, double index) {
    const std::string object = name.substr(name.find('_') + 1);
    const int kind = true_parts == 1 ? 2 : object == "Tshape" || object == "Lshape" || object == "chair" ? 1 : 0;
    right[kind] += found == true_parts;
    ++count[kind];
    rand[kind] += index;
    if (found != true_parts) std::printf("  %s: %d of %d, Rand %.3f\n", object.c_str(), found, true_parts, index);
  }
  void Print(const std::string& title) const {
    std::printf("%s: closed %d of %d (%.3f)  open %d of %d (%.3f)  single %d of %d (%.3f)\n", title.c_str(), right[0],
                count[0], rand[0] / count[0], right[1], count[1], rand[1] / count[1], right[2], count[2],
                rand[2] / count[2]);
    std::fflush(stdout);
  }
};

void RunRemesh(std::vector<double> sizes) {
  if (sizes.empty()) sizes = {500, 6000, 24000};
  for (double triangles : sizes) {
    Tally tally;
    for (const std::string& name : CleanCases()) {
      const test::SegmentationCase c = test::ReadSegmentationCase(Cases(), name);
      RemeshOptions options;
      options.triangles = static_cast<int>(triangles);
      const TriangleMesh mesh = Remesh(c.mesh, options);
      const PartSegmentation found = SegmentParts(mesh, SolveChargeDensity(mesh));
      tally.Add(name, c.n_parts, found.n_parts, test::RandIndex(found.labels, CarryLabels(c.mesh, c.labels, mesh)));
    }
    tally.Print("remeshed at " + std::to_string(static_cast<int>(triangles)));
  }
}

void RunNoise(std::vector<double> shares) {
  if (shares.empty()) shares = {0.003, 0.01};
  for (double share : shares) {
    Tally tally;
    std::uint64_t seed = 40;
    for (const std::string& name : CleanCases()) {
      const test::SegmentationCase c = test::ReadSegmentationCase(Cases(), name);
      const TriangleMesh mesh = test::WithNoise(c.mesh, share * test::BoxDiagonal(c.mesh), ++seed);
      const PartSegmentation found = SegmentParts(mesh, SolveChargeDensity(mesh));
      tally.Add(name, c.n_parts, found.n_parts, test::RandIndex(found.labels, c.labels));
    }
    tally.Print("noise of " + std::to_string(share));
  }
}

void RunPsb(const std::filesystem::path& folder) {
  constexpr int kDraws = 5;
  for (int id : {161, 81, 125}) {
    const TriangleMesh clean = test::ReadOff(folder / "off" / (std::to_string(id) + ".off"));
    std::vector<std::vector<int>> people;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "seg" / std::to_string(id))) {
      std::ifstream in(entry.path());
      people.push_back({std::istream_iterator<int>(in), std::istream_iterator<int>()});
    }
    std::printf("mesh %d:", id);
    for (double share : {0.0, 0.002, 0.005}) {
      double all = 0.0, worst = 0.0;
      const int draws = share > 0.0 ? kDraws : 1;
      for (int draw = 0; draw < draws; ++draw) {
        const TriangleMesh mesh = test::WithNoise(clean, share * test::BoxDiagonal(clean), 17 + draw);
        const PartSegmentation found = SegmentParts(mesh, SolveChargeDensity(mesh));
        double sum = 0.0;
        for (const std::vector<int>& human : people) sum += 1.0 - test::RandIndex(found.labels, human);
        const double mean = sum / static_cast<double>(people.size());
        all += mean / draws;
        worst = std::max(worst, mean);
      }
      std::printf("  %.1f %%: %.3f (worst %.3f)", 100.0 * share, all, worst);
      std::fflush(stdout);
    }
    std::printf("\n");
  }
}

void RunTurn() {
  double sum = 0.0, turned_sum = 0.0, worst = 0.0;
  const std::vector<std::string> names = CleanCases();
  for (const std::string& name : names) {
    const test::SegmentationCase c = test::ReadSegmentationCase(Cases(), name);
    TriangleMesh turned = c.mesh;
    const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.3, 1.0, -0.4).normalized()).toRotationMatrix();
    for (Eigen::Vector3d& v : turned.vertices) v = R * v;
    std::reverse(turned.triangles.begin(), turned.triangles.end());
    ChargeDensity charge = c.charge;
    std::reverse(charge.density.begin(), charge.density.end());
    std::vector<int> labels = c.labels;
    std::reverse(labels.begin(), labels.end());
    const double index = test::RandIndex(SegmentParts(c.mesh, c.charge).labels, c.labels);
    const double again = test::RandIndex(SegmentParts(turned, charge).labels, labels);
    sum += index;
    turned_sum += again;
    worst = std::max(worst, std::abs(index - again));
  }
  std::printf("mean index %.4f, turned and renumbered %.4f, largest difference of one object %.4f\n",
              sum / names.size(), turned_sum / names.size(), worst);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  std::vector<double> numbers;
  for (int i = 2; i < argc && what != "psb"; ++i) numbers.push_back(std::atof(argv[i]));
  if (what == "remesh") {
    RunRemesh(numbers);
  } else if (what == "noise") {
    RunNoise(numbers);
  } else if (what == "psb" && argc > 2) {
    RunPsb(argv[2]);
  } else if (what == "turn") {
    RunTurn();
  } else {
    std::fprintf(stderr, "usage: parts_sweep_validation remesh|noise|turn [numbers], or psb FOLDER\n");
    return 2;
  }
  return 0;
}
