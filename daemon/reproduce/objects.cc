// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/objects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/base/progress.h"
#include "core/surface/remesh.h"
#include "core/surface/signed_grid.h"
#include "sim/random.h"

namespace geond::reproduce {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0, kMm = 1e-3;

Pose PoseAt(const Eigen::Vector3d& position_mm, const Eigen::Vector3d& rpy_deg) {
  return Pose::Translation(kMm * position_mm) * Pose::Rotation(Eigen::Vector3d::UnitZ(), kDegree * rpy_deg.z()) *
         Pose::Rotation(Eigen::Vector3d::UnitY(), kDegree * rpy_deg.y()) *
         Pose::Rotation(Eigen::Vector3d::UnitX(), kDegree * rpy_deg.x());
}

Geon MakeGeon(GeonType type, const Eigen::Vector3d& size_mm, const Eigen::Vector3d& position_mm,
              const Eigen::Vector3d& rpy_deg = {0, 0, 0}, const Eigen::Vector2d& taper = {0, 0}, double bend_per_mm = 0.0) {
  Geon geon;
  geon.type = type;
  geon.size = kMm * size_mm;
  geon.taper = taper;
  geon.bend = bend_per_mm / kMm;
  geon.X_TG = PoseAt(position_mm, rpy_deg);
  return geon;
}

// Lifts or lowers everything so that the lowest point stands on the table.
void RestOnTable(sim::Scene& scene) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& part : scene.parts) lowest = std::min(lowest, sim::GeonSurface(part.geon).lowest_z());
  for (const auto& body : scene.bodies) {
    for (const Eigen::Vector3d& v : body.mesh.vertices) lowest = std::min(lowest, v.z());
  }
  const Pose lift = Pose::Translation({0, 0, -lowest});
  for (auto& part : scene.parts) part.geon.X_TG = lift * part.geon.X_TG;
  for (auto& body : scene.bodies) body.mesh = Transform(lift, body.mesh);
}

sim::Scene MakeScene(const std::string& name, const std::vector<sim::Scene::Part>& parts) {
  sim::Scene scene;
  scene.name = name;
  scene.parts = parts;
  RestOnTable(scene);
  return scene;
}

// A first-order signed distance to the union, m, and the geon that gives it.
std::pair<double, int> UnionDistance(const std::vector<sim::GeonSurface>& surfaces, const Eigen::Vector3d& p) {
  std::pair<double, int> least{std::numeric_limits<double>::infinity(), -1};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const auto value = surfaces[i].At(p);
    const double distance = (value.value - 1.0) / std::max(1e-9, value.gradient.norm());
    if (distance < least.first) least = {distance, static_cast<int>(i)};
  }
  return least;
}

std::vector<sim::GeonSurface> Surfaces(const sim::Scene& scene) {
  std::vector<sim::GeonSurface> surfaces;
  for (const auto& part : scene.parts) surfaces.emplace_back(part.geon);
  return surfaces;
}

}  // namespace

sim::Scene SingleGeon(GeonType type, const Eigen::Vector3d& size_mm, const Eigen::Vector2d& taper, double bend_per_mm,
                      const Eigen::Vector3d& rpy_deg, const std::string& name) {
  return MakeScene(name, {{name, MakeGeon(type, size_mm, {0, 0, 0}, rpy_deg, taper, bend_per_mm)}});
}

std::vector<sim::Scene> SevenObjects() {
  using T = GeonType;
  return {SingleGeon(T::kEllipsoid, {55, 38, 45}, {0, 0}, 0, {0, 0, 25}, "ellipsoid"),
          SingleGeon(T::kCylinder, {33, 33, 55}, {0, 0}, 0, {0, 0, 0}, "cylinder"),
          SingleGeon(T::kCuboid, {55, 35, 42}, {0, 0}, 0, {0, 0, 20}, "cuboid"),
          SingleGeon(T::kTaperedCylinder, {32, 32, 50}, {0.5, 0.5}, 0, {180, 0, 0}, "tapered cylinder"),
          SingleGeon(T::kTaperedCuboid, {42, 32, 45}, {0.5, 0.5}, 0, {180, 0, 15}, "tapered cuboid"),
          SingleGeon(T::kCurvedCylinder, {17, 17, 75}, {0, 0}, 0.014, {90, 0, 0}, "curved cylinder"),
          SingleGeon(T::kCurvedCuboid, {16, 20, 70}, {0, 0}, 0.014, {90, 0, 30}, "curved cuboid")};
}

sim::Scene BowlingPin() {
  // The neck's wide end is up, as its printed rotation has it.
  return MakeScene("bowling pin", {{"belly", MakeGeon(GeonType::kEllipsoid, {21.503, 21.987, 38.048}, {0, 0, 0})},
                                   {"neck", MakeGeon(GeonType::kTaperedCylinder, {8.72, 8.676, 20.696}, {0, 0, 56.1}, {0, 0, 0},
                                                     {0.3379, 0.3515})}});
}

sim::Scene Vase() {
  return MakeScene("vase", {{"ball", MakeGeon(GeonType::kEllipsoid, {40, 40, 40}, {0, 0, 0})},
                            {"tube", MakeGeon(GeonType::kCylinder, {17, 17, 35}, {0, 0, 62})}});
}

sim::Scene Owl() {
  return MakeScene("owl", {{"stump", MakeGeon(GeonType::kTaperedCylinder, {26, 26, 14}, {0, 0, 14}, {180, 0, 0}, {0.25, 0.25})},
                           {"body", MakeGeon(GeonType::kEllipsoid, {34, 34, 48}, {0, 0, 66.6})},
                           {"head", MakeGeon(GeonType::kEllipsoid, {25, 25, 22}, {0, 0, 115.5})}});
}

sim::Scene Clock() {
  // A drum that faces the sensor, with two balls on its rim.
  return MakeScene("clock", {{"drum", MakeGeon(GeonType::kCylinder, {50, 50, 22}, {0, 0, 0}, {90, 0, 0})},
                             {"left bell", MakeGeon(GeonType::kEllipsoid, {19, 19, 19}, {40, 0, 50})},
                             {"right bell", MakeGeon(GeonType::kEllipsoid, {19, 19, 19}, {-40, 0, 50})}});
}

sim::Scene Elephant() {
  using T = GeonType;
  const Eigen::Vector3d leg(13, 13, 32);
  return MakeScene("elephant",
                   {{"body", MakeGeon(T::kEllipsoid, {62, 38, 42}, {0, 0, 0})},
                    {"head", MakeGeon(T::kEllipsoid, {28, 26, 29}, {76, 0, 18})},
                    {"left fore leg", MakeGeon(T::kCylinder, leg, {36, 22, -54})},
                    {"right fore leg", MakeGeon(T::kCylinder, leg, {36, -22, -54})},
                    {"left hind leg", MakeGeon(T::kCylinder, leg, {-36, 22, -54})},
                    {"right hind leg", MakeGeon(T::kCylinder, leg, {-36, -22, -54})},
                    {"trunk", MakeGeon(T::kCurvedCylinder, {8, 8, 42}, {108, 0, -14}, {0, 10, 180}, {0, 0}, 0.014)},
                    {"left ear", MakeGeon(T::kEllipsoid, {20, 30, 6}, {66, 42, 26}, {55, 0, 0})},
                    {"right ear", MakeGeon(T::kEllipsoid, {20, 30, 6}, {66, -42, 26}, {-55, 0, 0})},
                    {"left tusk", MakeGeon(T::kTaperedCylinder, {4.5, 4.5, 20}, {106, 15, -2}, {0, 105, 0}, {0.0, 0.0})},
                    {"right tusk", MakeGeon(T::kTaperedCylinder, {4.5, 4.5, 20}, {106, -15, -2}, {0, 105, 0}, {0.0, 0.0})}});
}

sim::Scene CylinderAndBall() {
  return MakeScene("cylinder and ellipsoid", {{"cylinder", MakeGeon(GeonType::kCylinder, {28, 28, 40}, {0, 0, 0})},
                                              {"ball", MakeGeon(GeonType::kEllipsoid, {24, 24, 30}, {0, 0, 64})}});
}

std::vector<int> TrueLabels(const sim::Scene& scene, const TriangleMesh& mesh) {
  const std::vector<sim::GeonSurface> surfaces = Surfaces(scene);
  std::vector<int> labels;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d p = TriangleCentroid(mesh, static_cast<int>(t));
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const auto value = surfaces[i].At(p);
      const double distance = std::abs(value.value - 1.0) / std::max(1e-9, value.gradient.norm());
      if (distance < least) least = distance, best = static_cast<int>(i);
    }
    labels.push_back(best);
  }
  return labels;
}

UnionSurface MeshOfUnion(const sim::Scene& scene, int triangles, int threads, std::stop_token stop) {
  const std::vector<sim::GeonSurface> surfaces = Surfaces(scene);
  Eigen::AlignedBox3d box;
  for (const sim::GeonSurface& surface : surfaces) {
    for (const Eigen::Vector3d& v : surface.shell().vertices) box.extend(v);
  }
  SignedGrid grid(box, box.diagonal().norm() / 130.0, 1.0f);
  for (int k = 0; k < grid.size[2]; ++k) {
    ThrowIfStopped(stop);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        grid.value[grid.index(i, j, k)] = static_cast<float>(UnionDistance(surfaces, grid.node(i, j, k)).first);
      }
    }
  }
  const auto project = [&](const Eigen::Vector3d& p, const Eigen::Vector3d&) {
    Eigen::Vector3d q = p;
    for (int step = 0; step < 3; ++step) {
      const auto [distance, geon] = UnionDistance(surfaces, q);
      const Eigen::Vector3d gradient = surfaces[static_cast<std::size_t>(geon)].At(q).gradient;
      q -= std::clamp(distance, -grid.step, grid.step) * gradient.normalized();
    }
    return q;
  };
  RemeshOptions options;
  options.triangles = triangles;
  options.threads = threads;
  UnionSurface result;
  result.mesh = RemeshOnto(MarchingTetrahedra(grid), project, options, stop);
  result.labels = TrueLabels(scene, result.mesh);
  return result;
}

double RandIndex(const TriangleMesh& mesh, const std::vector<int>& a, const std::vector<int>& b) {
  std::map<std::pair<int, int>, double> both;
  std::map<int, double> of_a, of_b;
  double total = 0.0, squares = 0.0, squares_a = 0.0, squares_b = 0.0, squares_both = 0.0;
  const std::vector<double> areas = TriangleAreas(mesh);
  for (std::size_t t = 0; t < areas.size(); ++t) {
    if (a[t] < 0 || b[t] < 0) continue;
    both[{a[t], b[t]}] += areas[t];
    of_a[a[t]] += areas[t];
    of_b[b[t]] += areas[t];
    total += areas[t];
    squares += areas[t] * areas[t];
  }
  for (const auto& [key, area] : both) squares_both += area * area;
  for (const auto& [key, area] : of_a) squares_a += area * area;
  for (const auto& [key, area] : of_b) squares_b += area * area;
  return (total * total - squares_a - squares_b + 2.0 * squares_both - squares) / (total * total - squares);
}

}  // namespace geond::reproduce
