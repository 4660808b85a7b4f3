// SPDX-License-Identifier: Apache-2.0
// Fits all seven types to the scans of tests/data/geon/fit_cases.json and prints each least residual over the best known.
#include <cstdio>
#include <ctime>
#include <string>

#include "core/geon/fit.h"
#include "tests/core/geon/geon_cases.h"

int main() {
  using namespace geond;
  const auto file = ReadJson(GEOND_TEST_DATA "/geon/fit_cases.json");
  int within = 0, entries = 0, right = 0, scans = 0, evaluations = 0;
  double seconds = 0.0;
  std::printf("type views   found   least objective over the best known, types 1 to 7\n");
  for (const auto& item : file.at("fits")) {
    FitOptions options;
    options.threads = 1;
    options.outline_of_one_view = false;   // the best known are of the thesis' objective alone
    const PointCloud part = CloudOfCase(item);
    const std::clock_t begin = std::clock();
    const auto fits = FitGeons(part, options);
    seconds += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    double ratio[8] = {};
    for (const GeonFit& fit : fits) {
      const int type = static_cast<int>(fit.geon.type);
      ratio[type] = fit.objective / item.at("best_known").at(std::to_string(type)).at("E").get<double>();
      within += ratio[type] <= 1.01;
      ++entries;
      evaluations += fit.evaluations;
    }
    ++scans;
    const int found = static_cast<int>(fits.front().geon.type);
    right += found == item.at("type").get<int>();
    std::printf("%4d %5d %7d  ", item.at("type").get<int>(), item.at("views").get<int>(), found);
    for (int t = 1; t <= 7; ++t) std::printf(" %7.4f", ratio[t]);
    std::printf("   margin %.2f\n", fits.front().margin);
  }
  std::printf("within 1 %%: %d of %d; type right: %d of %d; %d evaluations and %.1f ms of processor a scan\n", within, entries, right, scans,
              evaluations / scans, 1e3 * seconds / scans);
}
