// SPDX-License-Identifier: Apache-2.0
// The table of the reference cases: parts found and Rand index, by quality of the mesh and kind of object.
// Usage: parts_cases_validation [--list] [trace|threshold]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/parts/segment.h"
#include "tests/core/parts/segmentation_case.h"

using namespace geond;

int main(int argc, char** argv) {
  const char* cases = std::getenv("GEOND_CASES");
  const std::filesystem::path folder =
      std::filesystem::path(cases ? cases : GEOND_SOURCE_DIR "/../shared/cases") / "segmentation";
  const bool list = argc > 1 && std::string(argv[1]) == "--list";
  const std::string method = argc > 1 ? argv[argc - 1] : "";
  const std::vector<std::string> open = {"Tshape", "Lshape", "chair"};
  struct Row {
    int right = 0, n = 0;
    double rand = 0.0;
  };
  std::map<std::string, std::map<std::string, Row>> table;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  const std::clock_t start = std::clock();
  for (const auto& file : files) {
    const std::string name = file.stem();
    const std::string quality = name.substr(0, name.find('_')), object = name.substr(name.find('_') + 1);
    const test::SegmentationCase c = test::ReadSegmentationCase(folder, name);
    SegmentOptions options;
    if (method == "trace") options.method = SegmentOptions::Method::kTrace;
    if (method == "threshold") options.method = SegmentOptions::Method::kThreshold;
    const PartSegmentation found = SegmentParts(c.mesh, c.charge, options);
    const std::string kind = c.n_parts == 1                                              ? "single"
                             : std::find(open.begin(), open.end(), object) != open.end() ? "open"
                                                                                         : "closed";
    Row& row = table[quality][kind];
    const double rand = test::RandIndex(found.labels, c.labels);
    row.right += found.n_parts == c.n_parts;
    row.rand += rand;
    ++row.n;
    if (list && (found.n_parts != c.n_parts || rand < 0.97)) {
      std::printf("%-24s %d of %d  %.3f\n", name.c_str(), found.n_parts, c.n_parts, rand);
    }
  }
  for (const auto& [quality, kinds] : table) {
    std::printf("%-10s", quality.c_str());
    for (const auto& [kind, row] : kinds) {
      std::printf("  %s %d of %d (Rand %.3f)", kind.c_str(), row.right, row.n, row.rand / row.n);
    }
    std::printf("\n");
  }
  std::printf("CPU seconds %.1f\n", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  return 0;
}
