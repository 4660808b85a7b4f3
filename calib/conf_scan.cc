// SPDX-License-Identifier: Apache-2.0
#include "calib/conf_scan.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "calib/grid_file.h"
#include "core/base/printed.h"
#include "core/base/error.h"

namespace geond::calib {
namespace {

constexpr double kMaxSlope = 6.0;       // depth over lateral distance within a cell; steeper is a depth jump
constexpr double kStandOff = 0.050;     // m between the sensor's plane and the nearest point
constexpr double kMaxPixels = 16e6;

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Pitch {
  double x = 0.0, y = 0.0;  // m between columns and rows
};

Pitch PitchOf(const PointGrid& grid) {
  std::vector<double> dx, dy;
  for (int r = 0; r + 1 < grid.rows; ++r) {
    for (int c = 0; c + 1 < grid.columns; ++c) {
      const std::size_t i = static_cast<std::size_t>(r) * grid.columns + c;
      const int here = grid.cells[i], right = grid.cells[i + 1], below = grid.cells[i + grid.columns];
      if (here >= 0 && right >= 0) dx.push_back(std::abs(grid.points[right].x() - grid.points[here].x()));
      if (here >= 0 && below >= 0) dy.push_back(std::abs(grid.points[below].y() - grid.points[here].y()));
    }
  }
  return {Median(std::move(dx)), Median(std::move(dy))};
}

// Writes the triangle's depth into the pixels whose centres it covers, the nearest surface kept.
void Draw(const SensorModel& sensor, const Eigen::Vector3d (&corners_S)[3], RangeImage& image) {
  Eigen::Vector2d uv[3];
  for (int k = 0; k < 3; ++k) uv[k] = *Project(sensor, corners_S[k]);
  const Eigen::Vector2d e1 = uv[1] - uv[0], e2 = uv[2] - uv[0];
  const double area = e1.x() * e2.y() - e1.y() * e2.x();
  if (std::abs(area) < 1e-12) return;
  const auto span = [&](int axis) {
    const auto [low, high] = std::minmax({uv[0][axis], uv[1][axis], uv[2][axis]});
    return std::pair(static_cast<int>(std::ceil(low - 1e-9)), static_cast<int>(std::floor(high + 1e-9)));
  };
  const auto [u0, u1] = span(0);
  const auto [v0, v1] = span(1);
  for (int v = std::max(0, v0); v <= std::min(image.rows - 1, v1); ++v) {
    for (int u = std::max(0, u0); u <= std::min(image.columns - 1, u1); ++u) {
      const Eigen::Vector2d d = Eigen::Vector2d(u, v) - uv[0];
      const double b = (d.x() * e2.y() - d.y() * e2.x()) / area, c = (e1.x() * d.y() - e1.y() * d.x()) / area;
      if (b < -1e-9 || c < -1e-9 || b + c > 1.0 + 1e-9) continue;
      const double z = corners_S[0].z() + b * (corners_S[1].z() - corners_S[0].z()) +
                       c * (corners_S[2].z() - corners_S[0].z());
      float& depth = image.depth[image.index(u, v)];
      if (!(depth <= z)) depth = static_cast<float>(z);
    }
  }
}

RecordedScan::View ViewOf(const PointGrid& grid, const std::filesystem::path& path) {
  const Pitch pitch = PitchOf(grid);
  if (!(pitch.x > 0.0) || !(pitch.y > 0.0)) {
    throw FileError(path.string(), "sample the grid", "neighbouring cells have no distance in x or y",
                    "The file must have x along its columns and y along its rows");
  }
  Eigen::Vector3d low = grid.points[0], high = grid.points[0];
  for (const auto& p : grid.points) low = low.cwiseMin(p), high = high.cwiseMax(p);

  // S: x as in the file, y down, z away from the sensor, which looks along -z of the file.
  Eigen::Matrix3d turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Pose X_FS(turn, Eigen::Vector3d(low.x(), high.y(), high.z() + kStandOff));
  RecordedScan::View view;
  SensorModel& sensor = view.sensor;
  sensor.projection = SensorModel::Projection::kOrthographic;
  const double columns = std::floor((high.x() - low.x()) / pitch.x) + 1, rows = std::floor((high.y() - low.y()) / pitch.y) + 1;
  if (!(columns * rows <= kMaxPixels)) {
    throw FileError(path.string(), "sample the grid",
                    Printed("%.0f x %.0f pixels are needed at its pitch", columns, rows), "A stray point may be the cause");
  }
  sensor.columns = static_cast<int>(columns);
  sensor.rows = static_cast<int>(rows);
  sensor.focal_u = 1.0 / pitch.x;
  sensor.focal_v = 1.0 / pitch.y;
  sensor.max_depth = high.z() - low.z() + 2.0 * kStandOff;
  RangeImage& image = view.exposure.image;
  image.columns = sensor.columns;
  image.rows = sensor.rows;
  image.depth.assign(static_cast<std::size_t>(image.columns) * image.rows, std::numeric_limits<float>::quiet_NaN());

  const Pose X_SF = Inverse(X_FS);
  std::vector<Eigen::Vector3d> points_S;
  for (const auto& p : grid.points) points_S.push_back(X_SF * p);
  const auto draw = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const Eigen::Vector3d corners[3] = {points_S[a], points_S[b], points_S[c]};
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d edge = corners[(k + 1) % 3] - corners[k];
      if (std::abs(edge.z()) > kMaxSlope * edge.head<2>().norm()) return;
      if (edge.head<2>().norm() > 3.0 * std::hypot(pitch.x, pitch.y)) return;
    }
    Draw(sensor, corners, image);
  };
  for (int r = 0; r + 1 < grid.rows; ++r) {
    for (int c = 0; c + 1 < grid.columns; ++c) {
      const std::size_t i = static_cast<std::size_t>(r) * grid.columns + c;
      const int a = grid.cells[i], b = grid.cells[i + 1], d = grid.cells[i + grid.columns],
                e = grid.cells[i + grid.columns + 1];
      if (b >= 0 && d >= 0) {
        draw(a, b, d);
        draw(b, e, d);
      } else {
        draw(a, b, e);
        draw(a, e, d);
      }
    }
  }
  view.X_TS_measured = X_FS;  // the caller puts the file's pose before it
  return view;
}

}  // namespace

RecordedScan ReadConfScan(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw FileError(path.string(), "read scan list", "the file cannot be opened", "Check name and permissions");
  RecordedScan scan;
  scan.has_table = false;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    std::istringstream words(line);
    std::string key, name;
    words >> key;
    if (key != "bmesh" && key != "mesh") continue;  // the camera of the picture, comments
    double t[3], q[4];
    words >> name >> t[0] >> t[1] >> t[2] >> q[0] >> q[1] >> q[2] >> q[3];
    const Eigen::Quaterniond rotation(q[3], -q[0], -q[1], -q[2]);
    if (!words || !(rotation.norm() > 0.5 && rotation.norm() < 2.0) || !std::isfinite(t[0] + t[1] + t[2])) {
      throw FileError(path.string(), "read scan list", Printed("line %d is not 'bmesh FILE tx ty tz qx qy qz qw'", number));
    }
    std::filesystem::path grid_path = path.parent_path() / name;
    if (!std::filesystem::exists(grid_path)) grid_path += ".xz";
    if (!std::filesystem::exists(grid_path)) {
      throw FileError(path.string(), "read scan list",
                      Printed("line %d names %s, which is not there, nor with .xz", number, name.c_str()),
                      "Put the range images beside the list");
    }
    const PointGrid grid = ReadGridFile(grid_path);
    if (grid.points.empty()) throw FileError(grid_path.string(), "read range grid", "it has no points");
    RecordedScan::View view = ViewOf(grid, grid_path);
    view.X_TS_measured = Pose(rotation, Eigen::Vector3d(t[0], t[1], t[2])) * view.X_TS_measured;
    scan.views.push_back(std::move(view));
  }
  if (scan.views.empty()) {
    throw FileError(path.string(), "read scan list", "no line 'bmesh FILE tx ty tz qx qy qz qw' in it");
  }
  scan.station.sensor = scan.views[0].sensor;
  return scan;
}

}  // namespace geond::calib
