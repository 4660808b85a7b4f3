// SPDX-License-Identifier: Apache-2.0
// From many data to a fine mesh: seconds of processor time and peak memory of `Tessellate` for 8 views, by the number of data and
// of triangles, and what each doubling costs.
#include <cstdio>
#include <ctime>

#include <sys/resource.h>

#include "calib/make_view.h"
#include "core/surface/integrate.h"
#include "core/surface/tessellate.h"
#include "tests/calib/synthetic_scan.h"

int main() {
  using namespace geond;
  std::printf("%7s %8s %8s %9s | %7s %7s %7s | %6s\n", "pixels", "data", "merged", "triangles", "merge s", "mesh s", "ratio", "MB");
  double before = 0.0;
  for (const auto& [pixels, triangles] : {std::pair{120, 5'000}, {170, 10'000}, {240, 20'000}, {340, 20'000}}) {
    const auto views = calib::MakeViews(
        calib::SyntheticScan(calib::BoxAndSphere(), 8, 0.0002, 1, calib::SyntheticStation(pixels, 0.12)));
    std::size_t data = 0;
    for (const RangeView& view : views) data += ViewCloud(view).size();
    const std::clock_t start = std::clock();
    const PointCloud merged = IntegrateViews(views);
    const std::clock_t between = std::clock();
    const TriangleMesh mesh = Tessellate(views, merged, {.triangles = triangles});
    const double seconds = static_cast<double>(std::clock() - between) / CLOCKS_PER_SEC;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    std::printf("%7d %8zu %8zu %9zu | %7.2f %7.2f %7.2f | %6ld\n", pixels, data, merged.size(), mesh.triangles.size(),
                static_cast<double>(between - start) / CLOCKS_PER_SEC, seconds, before > 0.0 ? seconds / before : 1.0,
                usage.ru_maxrss / 1024);
    std::fflush(stdout);
    before = seconds;
  }
}
