// SPDX-License-Identifier: Apache-2.0
// The Princeton Segmentation Benchmark (Chen, Golovinskiy and Funkhouser 2009): dissimilarity by the Rand index (pairs
// of triangles, not weighted) to each human segmentation of a mesh, averaged over these, the meshes of a category, and
// all; for those the weights of cuts were fitted to ("fitted": (id - 1) / 2 even) and the others apart. Reads
// <GEOND_DATA>/psb unpacked (off/ID.off, seg/ID/ID_K.seg), or the folder given. Usage: parts_psb_validation FOLDER
// [ID...]      GEOND_PARTS_DETAIL sets the detail; charges are kept in FOLDER/charge.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/parts/segment.h"
#include "tests/core/parts/segmentation_case.h"

using namespace geond;

namespace {

constexpr const char* kCategories[] = {"Human",     "Cup",   "Glasses", "Airplane", "Ant",  "Chair",  "Octopus",
                                       "Table",     "Teddy", "Hand",    "Plier",    "Fish", "Bird",   "(none)",
                                       "Armadillo", "Bust",  "Mech",    "Bearing",  "Vase", "Fourleg"};

constexpr int kConcave[] = {4, 6, 8, 9, 10, 2, 12, 11, 19, 14};  // categories whose parts meet in concavities

struct Mean {
  double sum = 0.0;
  int n = 0;
  void Add(double value) { sum += value, ++n; }
  double value() const { return n ? sum / n : 0.0; }
};

// The charge from the cache, or solved and kept there.
ChargeDensity Charge(const TriangleMesh& mesh, const std::filesystem::path& cache) {
  ChargeDensity charge;
  charge.density.resize(mesh.triangles.size());
  const auto bytes = static_cast<std::streamsize>(charge.density.size() * sizeof(double));
  std::ifstream in(cache, std::ios::binary);
  if (in && in.read(reinterpret_cast<char*>(charge.density.data()), bytes)) return charge;
  // A triangle without area, as the solver judges it, cannot be solved for (mesh 351 has one): it bears nothing.
  std::vector<double> areas = TriangleAreas(mesh);
  for (std::size_t t = 0; t < areas.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const double longest = std::max({(mesh.vertices[a] - mesh.vertices[b]).squaredNorm(),
                                     (mesh.vertices[b] - mesh.vertices[c]).squaredNorm(),
                                     (mesh.vertices[c] - mesh.vertices[a]).squaredNorm()});
    if (!(areas[t] > 1e-10 * longest)) areas[t] = 0.0;
  }
  TriangleMesh solid = mesh;
  solid.triangles.clear();
  for (std::size_t t = 0; t < areas.size(); ++t) {
    if (areas[t] > 0.0) solid.triangles.push_back(mesh.triangles[t]);
  }
  const ChargeDensity solved = SolveChargeDensity(solid);
  std::size_t next = 0;
  for (std::size_t t = 0; t < areas.size(); ++t) charge.density[t] = areas[t] > 0.0 ? solved.density[next++] : 0.0;
  std::filesystem::create_directories(cache.parent_path());
  std::ofstream(cache, std::ios::binary).write(reinterpret_cast<const char*>(charge.density.data()), bytes);
  return charge;
}

}  // namespace

int main(int argc, char** argv) {
  const char* data = std::getenv("GEOND_DATA");
  const std::filesystem::path folder =
      argc > 1 ? argv[1] : std::string(data ? data : GEOND_SOURCE_DIR "/../shared/data") + "/psb";
  if (!std::filesystem::exists(folder / "off")) {
    std::fprintf(stderr, "%s: no folder off; unpack psb_odd_off.tar.xz and psb_odd_seg.tar.xz there\n", folder.c_str());
    return 1;
  }
  SegmentOptions options;
  if (const char* detail = std::getenv("GEOND_PARTS_DETAIL")) options.detail = std::atof(detail);
  std::vector<int> ids;
  for (int i = 2; i < argc; ++i) ids.push_back(std::atoi(argv[i]));
  if (ids.empty()) {
    for (const auto& entry : std::filesystem::directory_iterator(folder / "off"))
      ids.push_back(std::stoi(entry.path().stem()));
    std::sort(ids.begin(), ids.end());
  }
  std::map<int, std::pair<double, int>> by_category;
  Mean by_half[4];  // fitted, others; the same of the concave categories
  double sum = 0.0, cpu = 0.0, worst_cpu = 0.0;
  for (int id : ids) {
    const TriangleMesh mesh = test::ReadOff(folder / "off" / (std::to_string(id) + ".off"));
    const ChargeDensity charge = Charge(mesh, folder / "charge" / (std::to_string(id) + ".bin"));
    const std::clock_t start = std::clock();
    const PartSegmentation found = SegmentParts(mesh, charge, options);
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    double dissimilarity = 0.0, human_parts = 0.0;
    int humans = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "seg" / std::to_string(id))) {
      std::ifstream in(entry.path());
      const std::vector<int> human{std::istream_iterator<int>(in), std::istream_iterator<int>()};
      if (human.size() != mesh.triangles.size()) continue;
      dissimilarity += 1.0 - test::RandIndex(found.labels, human);
      human_parts += 1 + *std::max_element(human.begin(), human.end());
      ++humans;
    }
    if (humans == 0) continue;
    dissimilarity /= humans;
    const int category = (id - 1) / 20;
    std::printf("%3d %-9s %.3f  parts %2d (humans %.1f)  %zu triangles, %.2f s\n", id, kCategories[category],
                dissimilarity, found.n_parts, human_parts / humans, mesh.triangles.size(), seconds);
    std::fflush(stdout);
    const int half = (id - 1) / 2 % 2;
    by_half[half].Add(dissimilarity);
    if (std::ranges::count(kConcave, category)) by_half[2 + half].Add(dissimilarity);
    by_category[category].first += dissimilarity;
    ++by_category[category].second;
    sum += dissimilarity;
    cpu += seconds;
    worst_cpu = std::max(worst_cpu, seconds);
  }
  std::printf("fitted %.4f (%d), others %.4f (%d); of these parts that meet in concavities %.4f (%d), %.4f (%d)\n",
              by_half[0].value(), by_half[0].n, by_half[1].value(), by_half[1].n, by_half[2].value(), by_half[2].n,
              by_half[3].value(), by_half[3].n);
  double concave = 0.0, n = 0.0;
  int n_concave = 0;
  for (const auto& [category, total] : by_category) {
    std::printf("%-9s %.3f  (%d)\n", kCategories[category], total.first / total.second, total.second);
    n += total.second;
    if (std::ranges::count(kConcave, category)) concave += total.first, n_concave += total.second;
  }
  std::printf("all %.4f over %.0f meshes; parts that meet in concavities %.4f over %d; CPU %.0f s, worst %.2f s\n",
              sum / n, n, n_concave ? concave / n_concave : 0.0, n_concave, cpu, worst_cpu);
  return 0;
}
