// SPDX-License-Identifier: Apache-2.0
#include "calib/make_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "calib/depth_jumps.h"
#include "core/base/printed.h"
#include "calib/speckles.h"

namespace geond::calib {
namespace {

constexpr double kTableReach = 1.2;  // the table is asked up to this times the radius of the work space

struct CutView {
  RangeView view;
  TablePlane table;
};

std::vector<Eigen::Vector3d> ReturnsInTurntable(const RangeView& view) {
  std::vector<Eigen::Vector3d> points(view.image.depth.size(),
                                      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      const double depth = view.image.at(column, row);
      if (std::isfinite(depth) && depth >= view.sensor.min_depth) {
        points[view.image.index(column, row)] = view.X_TS * Unproject(view.sensor, column, row, depth);
      }
    }
  }
  return points;
}

// Standard deviation of a table return's height: the noise along the ray times the ray's slope on the table.
double HeightNoise(const RangeView& view) {
  const Eigen::Vector3d axis_T = view.X_TS.Rotate(Eigen::Vector3d::UnitZ());
  return std::max(0.00005, view.sensor.depth_noise * std::abs(axis_T.z()));
}

CutView Cut(const Exposure& exposure, const SensorModel& sensor, const StationGeometry& station, bool has_table,
            const Pose& X_TS_measured, const Pose& X_TS, const NormalOptions& options, int threads) {
  if (exposure.image.columns != sensor.columns || exposure.image.rows != sensor.rows ||
      exposure.image.depth.size() != static_cast<std::size_t>(sensor.columns) * sensor.rows) {
    throw std::invalid_argument(Printed("MakeView: the image has %d x %d pixels, the sensor model %d x %d",
                                        exposure.image.columns, exposure.image.rows, sensor.columns, sensor.rows));
  }
  CutView cut;
  RangeView& view = cut.view;
  view.sensor = sensor;
  view.image = exposure.image;
  view.table_angle = exposure.table_angle;
  view.X_TS_measured = X_TS_measured;
  view.X_TS = X_TS;
  view.classes.assign(view.image.depth.size(), PixelClass::kNothing);

  const std::vector<Eigen::Vector3d> points_T = ReturnsInTurntable(view);
  if (has_table) {
    std::vector<Eigen::Vector3d> asked;
    for (const auto& p : points_T) {
      if (p.allFinite() && p.head<2>().norm() <= kTableReach * station.object_radius) asked.push_back(p);
    }
    TablePlaneOptions table_options;
    table_options.noise = std::max(HeightNoise(view), 0.0001);
    cut.table = FitTablePlane(asked, table_options);
  }
  const double clearance = std::max(station.table_clearance, 4.0 * cut.table.rms);
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    const Eigen::Vector3d& p = points_T[i];
    if (!p.allFinite()) continue;
    PixelClass& what = view.classes[i];
    if (view.image.depth[i] > sensor.max_depth) {
      what = PixelClass::kBackground;
    } else if (!has_table) {
      what = PixelClass::kObject;
    } else {
      const double height = cut.table.Height(p);
      const bool inside = p.head<2>().norm() <= station.object_radius && height <= station.object_height;
      if (height > clearance) {
        what = inside ? PixelClass::kObject : PixelClass::kBackground;
      } else {
        what = height >= -clearance ? PixelClass::kTable : PixelClass::kBackground;
      }
    }
  }
  RejectMixedPixels(view, options.max_incidence);
  RejectSpeckles(view);
  view = EstimateNormals(std::move(view), options, threads);
  return cut;
}

std::string TableNote(const std::vector<TablePlane>& tables) {
  int seen = 0;
  double tilt = 0.0, height = 0.0;
  for (const auto& table : tables) {
    if (!table.refined) continue;
    ++seen;
    tilt = std::max(tilt, table.Tilt());
    if (std::abs(table.offset) > std::abs(height)) height = table.offset;
  }
  if (seen == 0) {
    return "table: too few returns to refine its plane; the calibrated plane cuts the object from it";
  }
  return Printed("table: plane refined in %d of %zu views, at most %.2f deg and %+.2f mm from the calibration",
                 seen, tables.size(), tilt * 180.0 / std::numbers::pi, height * 1e3);
}

}  // namespace

RangeView MakeView(const Exposure& exposure, const StationGeometry& station, const NormalOptions& options,
                   int threads) {
  const Pose X_TS = SensorInTurntable(station, exposure.table_angle);
  return Cut(exposure, station.sensor, station, true, X_TS, X_TS, options, threads).view;
}

ViewsOfScan MakeViewsAndTables(const RecordedScan& scan, const NormalOptions& options, int threads) {
  ViewsOfScan made;
  for (std::size_t k = 0; k < scan.views.size(); ++k) {
    const auto& recorded = scan.views[k];
    CutView cut = Cut(recorded.exposure, recorded.sensor, scan.station, scan.has_table, recorded.X_TS_measured,
                      recorded.X_TS_refined.value_or(recorded.X_TS_measured), options, threads);
    const auto object = std::count(cut.view.classes.begin(), cut.view.classes.end(), PixelClass::kObject);
    if (object == 0) {
      made.notes.push_back(Printed("view %zu: nothing of the object in it (no return inside the work space)", k));
    }
    made.views.push_back(std::move(cut.view));
    made.tables.push_back(cut.table);
  }
  if (scan.has_table && !made.tables.empty()) made.notes.push_back(TableNote(made.tables));
  return made;
}

std::vector<RangeView> MakeViews(const RecordedScan& scan, const NormalOptions& options, int threads) {
  return MakeViewsAndTables(scan, options, threads).views;
}

}  // namespace geond::calib
