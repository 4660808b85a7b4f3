// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/parallel.h"
#include "core/geometry/triangle_mesh.h"
#include "core/range/range_view.h"
#include "core/surface/triangle_tree.h"

namespace geond {

// A point of the true surface (m), and its creases: normals of both sides.
struct TruthPoint {
  Eigen::Vector3d p, n, m = Eigen::Vector3d::Zero();
  bool seen;
};

struct SurfaceCase {
  std::string name;
  int genus = 0;
  std::vector<RangeView> views;
  std::vector<TruthPoint> truth, creases;
};

// The vertices of a binary little-endian PLY of float and uchar properties, by name.
inline std::map<std::string, std::vector<double>> ReadVertices(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  std::map<std::string, std::vector<double>> columns;
  std::vector<std::pair<std::string, std::string>> properties;
  std::size_t n = 0;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    char name[64], type[64];
    if (std::sscanf(line.c_str(), "element vertex %zu", &n) == 1) continue;
    if (std::sscanf(line.c_str(), "property %63s %63s", type, name) == 2) properties.emplace_back(name, type);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (const auto& [name, type] : properties) {
      double value = 0;
      if (type == "float") {
        float x;
        file.read(reinterpret_cast<char*>(&x), 4);
        value = x;
      } else if (type == "ushort") {
        std::uint16_t x;
        file.read(reinterpret_cast<char*>(&x), 2);
        value = x;
      } else {
        value = file.get();
      }
      columns[name].push_back(value);
    }
  }
  if (!file) throw std::runtime_error(path.string() + " is too short");
  return columns;
}

inline std::vector<TruthPoint> ReadTruth(const std::filesystem::path& path) {
  auto c = ReadVertices(path);
  std::vector<TruthPoint> points;
  for (std::size_t i = 0; i < c["x"].size(); ++i) {
    TruthPoint point;
    point.p = 1e-3 * Eigen::Vector3d(c["x"][i], c["y"][i], c["z"][i]);
    point.n = Eigen::Vector3d(c["nx"][i], c["ny"][i], c["nz"][i]).normalized();
    if (c.contains("mx")) point.m = Eigen::Vector3d(c["mx"][i], c["my"][i], c["mz"][i]).normalized();
    point.seen = c["seen"][i] != 0;
    points.push_back(point);
  }
  return points;
}

// A case of ranges along the rays (mm) as views with depths along the axis (m), true poses, normals estimated here.
inline SurfaceCase ReadSurfaceCase(const std::filesystem::path& folder) {
  SurfaceCase result;
  result.name = folder.filename().string();
  nlohmann::json json;
  std::ifstream(folder / "case.json") >> json;
  result.genus = json.at("genus");
  for (const auto& entry : json.at("views")) {
    RangeView view;
    std::ifstream file(folder / entry.at("range").get<std::string>(), std::ios::binary);
    std::int32_t size[2];
    float frame[3];
    file.read(reinterpret_cast<char*>(size), 8).read(reinterpret_cast<char*>(frame), 12);
    const std::size_t n = static_cast<std::size_t>(size[0]) * size[1];
    std::vector<float> ranges(n);
    file.read(reinterpret_cast<char*>(ranges.data()), 4 * n);
    std::vector<char> status(n);
    std::ifstream(folder / entry.at("status").get<std::string>(), std::ios::binary).read(status.data(), n);
    if (!file) throw std::runtime_error(folder.string() + ": a range file is too short");
    view.image.rows = view.sensor.rows = size[0];
    view.image.columns = view.sensor.columns = size[1];
    view.sensor.focal_u = view.sensor.focal_v = 1.0 / frame[2];
    view.sensor.center_u = -frame[0] / frame[2];
    view.sensor.center_v = -frame[1] / frame[2];
    view.sensor.depth_noise = 1e-3 * json.at("noise_sigma").get<double>();
    view.image.depth.assign(n, std::numeric_limits<float>::quiet_NaN());
    view.classes.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double column = static_cast<double>(i % size[1]), row = static_cast<double>(i / size[1]);
      constexpr PixelClass kClasses[]{PixelClass::kNothing, PixelClass::kObject, PixelClass::kRejected, PixelClass::kTable};
      view.classes[i] = kClasses[static_cast<int>(status[i])];
      if (ranges[i] > 0) view.image.depth[i] = static_cast<float>(1e-3 * ranges[i] * RayDirection(view.sensor, column, row).z());
    }
    Eigen::Matrix4d X;
    for (int r = 0; r < 4; ++r) for (int c = 0; c < 4; ++c) X(r, c) = entry.at("pose_true").at(r).at(c);
    view.X_TS = view.X_TS_measured = Pose(Eigen::Matrix3d(X.topLeftCorner<3, 3>()), 1e-3 * X.topRightCorner<3, 1>());
    result.views.push_back(EstimateNormals(std::move(view)));
  }
  result.truth = ReadTruth(folder / "truth.ply");
  result.creases = ReadTruth(folder / "creases.ply");
  return result;
}

// How a mesh compares with the truth: lengths in mm, angles in degrees.
struct SurfaceFigures {
  MeshTopology topology;
  double rms_seen = 0, rms_unseen = 0, worst_seen = 0;
  double contrast[3] = {0, 0, 0};  // share of the normals' turn kept 1, 2, 3 mm beside concave creases; NaN: none
  double convex[3] = {0, 0, 0};
  double crease_rms = 0;           // of the seen truth within 2 mm of a concave crease
  double min_angle = 0, min_angle_1 = 0, area_ratio = 0;
  double seen_share = 0;
};

inline SurfaceFigures Measure(const TriangleMesh& mesh, const SurfaceCase& surface) {
  SurfaceFigures figures;
  figures.topology = Topology(mesh);
  const TriangleTree tree(mesh.vertices, mesh.triangles);
  std::vector<double> distances(surface.truth.size());
  ParallelFor(static_cast<std::ptrdiff_t>(distances.size()), 0, 512, [&](std::ptrdiff_t i) {
    distances[i] = 1e3 * std::sqrt(tree.Nearest(surface.truth[i].p).squared_distance);
  });
  double sum[2] = {0, 0};
  int n[2] = {0, 0};
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const bool seen = surface.truth[i].seen;
    sum[seen] += distances[i] * distances[i];
    ++n[seen];
    if (seen) figures.worst_seen = std::max(figures.worst_seen, distances[i]);
  }
  figures.rms_seen = n[1] ? std::sqrt(sum[1] / n[1]) : NAN;
  figures.rms_unseen = n[0] ? std::sqrt(sum[0] / n[0]) : NAN;

  const std::vector<Eigen::Vector3d> normals = TriangleNormals(mesh);
  std::vector<Eigen::Vector3d> concave_points;
  for (int d = 0; d < 3; ++d) {
    double kept[2] = {0, 0};
    int count[2] = {0, 0};
    for (const TruthPoint& crease : surface.creases) {
      if (!crease.seen) continue;
      const Eigen::Vector3d along = crease.n.cross(crease.m).normalized();
      Eigen::Vector3d a = along.cross(crease.n);  // in face n, perpendicular to the crease
      Eigen::Vector3d b = along.cross(crease.m);
      // Away from the crease on a concave one is towards the other side's normal, on a convex one away from it. The
      // true surface tells which it is: the one nearer to it at 2 mm.
      double off[2];
      for (int convex = 0; convex < 2; ++convex) {
        const double sign = convex ? -1.0 : 1.0;
        const Eigen::Vector3d p = crease.p + 2e-3 * sign * (a.dot(crease.m) > 0 ? a : Eigen::Vector3d(-a));
        double nearest = 1e9;
        for (std::size_t i = 0; i < surface.truth.size(); i += 4) nearest = std::min(nearest, (surface.truth[i].p - p).squaredNorm());
        off[convex] = nearest;
      }
      const int convex = off[1] < off[0];
      const double sign = convex ? -1.0 : 1.0;
      a = sign * (a.dot(crease.m) > 0 ? a : Eigen::Vector3d(-a));
      b = sign * (b.dot(crease.n) > 0 ? b : Eigen::Vector3d(-b));
      const double step = 1e-3 * (d + 1);
      const Eigen::Vector3d na = normals[tree.Nearest(crease.p + step * a).triangle];
      const Eigen::Vector3d nb = normals[tree.Nearest(crease.p + step * b).triangle];
      const double turn = std::atan2(na.cross(nb).norm(), na.dot(nb));
      // What the true surface itself turns by between the two points.
      const auto true_normal = [&](const Eigen::Vector3d& p) {
        std::size_t best = 0;
        for (std::size_t i = 1; i < surface.truth.size(); ++i) {
          if ((surface.truth[i].p - p).squaredNorm() < (surface.truth[best].p - p).squaredNorm()) best = i;
        }
        return surface.truth[best].n;
      };
      const Eigen::Vector3d ta = true_normal(crease.p + step * a), tb = true_normal(crease.p + step * b);
      const double truth = std::atan2(ta.cross(tb).norm(), ta.dot(tb));
      kept[convex] += turn / truth;
      ++count[convex];
      if (d == 0 && !convex) concave_points.push_back(crease.p);
    }
    figures.contrast[d] = count[0] ? kept[0] / count[0] : NAN;
    figures.convex[d] = count[1] ? kept[1] / count[1] : NAN;
  }
  double crease_sum = 0;
  int crease_n = 0;
  for (std::size_t i = 0; i < surface.truth.size(); ++i) {
    if (!surface.truth[i].seen) continue;
    const bool near = std::any_of(concave_points.begin(), concave_points.end(), [&](const Eigen::Vector3d& c) {
      return (c - surface.truth[i].p).squaredNorm() < 4e-6;
    });
    if (near) crease_sum += distances[i] * distances[i], ++crease_n;
  }
  figures.crease_rms = crease_n ? std::sqrt(crease_sum / crease_n) : NAN;

  std::vector<double> angles, areas = TriangleAreas(mesh);
  for (const auto& triangle : mesh.triangles) {
    double smallest = 10;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d u = mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]];
      const Eigen::Vector3d v = mesh.vertices[triangle[(k + 2) % 3]] - mesh.vertices[triangle[k]];
      smallest = std::min(smallest, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
    angles.push_back(smallest * 180 / std::numbers::pi);
  }
  std::sort(angles.begin(), angles.end());
  std::sort(areas.begin(), areas.end());
  if (!areas.empty()) {
    figures.min_angle = angles.front();
    figures.min_angle_1 = angles[angles.size() / 100];
    figures.area_ratio = areas[areas.size() * 99 / 100] / areas[areas.size() / 100];
  }
  double seen = 0;
  for (std::uint8_t s : mesh.triangle_seen) seen += s;
  figures.seen_share = mesh.triangle_seen.empty() ? NAN : seen / static_cast<double>(mesh.triangle_seen.size());
  return figures;
}

}  // namespace geond
