// SPDX-License-Identifier: Apache-2.0
// CPU seconds of registration of a recorded case, repeated to more views, against one view's normals as the unit.
#include <cstdio>
#include <ctime>
#include <string>

#include "calib/make_view.h"
#include "calib/register_views.h"
#include "tests/calib/synthetic_scan.h"

using namespace geond;
using namespace geond::calib;

namespace {

double CpuSeconds(auto&& work) {
  const std::clock_t clock = std::clock();
  work();
  return static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
}

}  // namespace

int main() {
  std::printf("%5s %8s %12s %12s %12s %12s\n", "views", "points", "normals s", "axis s", "free s", "auto s");
  for (const int n : {4, 8, 12, 36}) {
    const RecordedScan scan = SyntheticScan(BoxAndSphere(), n, 0.0002, 1, SyntheticStation(225, 0.17));
    std::vector<RangeView> views;
    const double normals = CpuSeconds([&] { views = MakeViews(scan); });
    double seconds[3];
    for (int k = 0; k < 3; ++k) {
      RegisterOptions options;
      options.model = k == 0   ? RegisterOptions::Model::kTurntable
                      : k == 1 ? RegisterOptions::Model::kFree
                               : RegisterOptions::Model::kAuto;
      seconds[k] = CpuSeconds([&] { RegisterViews(views, options); });
    }
    std::printf("%5d %8zu %12.3f %12.3f %12.3f %12.3f\n", n, ViewCloud(views[0]).size(), normals, seconds[0], seconds[1],
                seconds[2]);
  }
}
