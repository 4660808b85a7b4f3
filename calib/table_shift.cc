// SPDX-License-Identifier: Apache-2.0
#include "calib/table_shift.h"

#include <algorithm>
#include <cstddef>

#include "calib/table_plane.h"

namespace geond::calib {
namespace {

constexpr std::size_t kMostReturns = 20'000;

}  // namespace

double ShiftOntoTable(std::vector<RangeView>& views) {
  std::size_t seen = 0;
  double noise = 0.0;
  for (const RangeView& view : views) {
    seen += static_cast<std::size_t>(std::count(view.classes.begin(), view.classes.end(), PixelClass::kTable));
    noise = std::max(noise, view.sensor.depth_noise);
  }
  const std::size_t stride = 1 + seen / kMostReturns;
  std::vector<Eigen::Vector3d> points_T;
  std::size_t count = 0;
  for (const RangeView& view : views) {
    for (int row = 0; row < view.image.rows; ++row) {
      for (int column = 0; column < view.image.columns; ++column) {
        const std::size_t pixel = view.image.index(column, row);
        if (view.classes[pixel] != PixelClass::kTable || count++ % stride != 0) continue;
        points_T.push_back(view.X_TS * Unproject(view.sensor, column, row, view.image.depth[pixel]));
      }
    }
  }
  TablePlaneOptions options;
  options.noise = std::max(noise, 0.0001);
  const TablePlane table = FitTablePlane(points_T, options);
  if (!table.refined) return 0.0;
  const double raise = -table.offset / table.normal_T.z();
  for (RangeView& view : views) view.X_TS = Pose::Translation({0.0, 0.0, raise}) * view.X_TS;
  return raise;
}

}  // namespace geond::calib
