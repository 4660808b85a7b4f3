// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>

#include "daemon/reproduce/objects.h"
#include "sim/random.h"

namespace geond::reproduce {
namespace {

constexpr double kPi = std::numbers::pi;

struct BananaShape {
  double length = 0.18;      // m, along the middle line
  double radius = 0.017;     // m, at the thickest
  double bend = 1.3;         // rad, of the whole
  double uneven = 0.0;       // how much more one half bends than the other, share of the bend
  double ridges = 0.05;      // share of the radius by which five ridges stand out
  double flatness = 1.0;     // thickness across the plane of the bend over that in it
  double blunt = 0.5;        // radius of the ends over the greatest
  double phase = 0.0;        // rad, of the ridges
};

// The tube in the plane x y, the ridges along it, both ends closed by caps.
TriangleMesh BananaMesh(const BananaShape& shape) {
  constexpr int kRings = 96, kAround = 60;
  TriangleMesh mesh;
  // The middle line: its direction turns by `bend` in all, faster in one half.
  std::vector<Eigen::Vector2d> line{{0, 0}};
  std::vector<double> heading;
  for (int i = 0; i <= kRings; ++i) {
    const double s = static_cast<double>(i) / kRings;
    heading.push_back(shape.bend * (s - 0.5 + shape.uneven * (s * s - s)));
    if (i < kRings) {
      line.push_back(line.back() + shape.length / kRings * Eigen::Vector2d(std::cos(heading.back()), std::sin(heading.back())));
    }
  }
  Eigen::Vector2d middle = 0.5 * (line.front() + line.back());
  for (int i = 0; i <= kRings; ++i) {
    const double s = 2.0 * i / kRings - 1.0;  // -1 to 1
    // Full in the middle, down to `blunt` towards the ends, closed over the last few per cent.
    const double body = shape.blunt + (1.0 - shape.blunt) * std::sqrt(std::max(0.0, 1.0 - std::pow(std::abs(s), 2.5)));
    const double end = std::clamp((1.0 - std::abs(s)) / 0.05, 0.0, 1.0);
    const double radius = shape.radius * body * std::sqrt(1.0 - (1.0 - end) * (1.0 - end));
    const Eigen::Vector3d across(-std::sin(heading[i]), std::cos(heading[i]), 0.0);
    const Eigen::Vector3d at(line[i].x() - middle.x(), line[i].y() - middle.y(), 0.0);
    for (int j = 0; j < kAround; ++j) {
      const double phi = 2.0 * kPi * j / kAround;
      const double r = std::max(radius, 1e-5) * (1.0 + shape.ridges * std::cos(5.0 * phi + shape.phase));
      mesh.vertices.push_back(at + r * std::cos(phi) * across + shape.flatness * r * std::sin(phi) * Eigen::Vector3d::UnitZ());
    }
  }
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const int a = i * kAround + j, b = i * kAround + (j + 1) % kAround, c = a + kAround, d = b + kAround;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
  }
  for (int j = 1; j + 1 < kAround; ++j) {
    mesh.triangles.push_back({0, j, j + 1});
    const int last = kRings * kAround;
    mesh.triangles.push_back({last, last + j + 1, last + j});
  }
  if (Volume(mesh) < 0.0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

}  // namespace

std::vector<sim::Scene> Bananas(int count) {
  std::vector<sim::Scene> bananas;
  for (int i = 0; i < count; ++i) {
    sim::CounterRandom random(1996, 0x62616e616e61u, static_cast<std::uint64_t>(i));
    const auto between = [&](double low, double high) { return low + (high - low) * random.Uniform(); };
    BananaShape shape;
    shape.length = between(0.150, 0.200);
    shape.radius = between(0.0150, 0.0190);
    shape.bend = between(1.0, 1.9);
    shape.uneven = between(-0.35, 0.35);
    shape.ridges = between(0.02, 0.06);
    shape.flatness = between(0.90, 1.05);
    shape.blunt = between(0.35, 0.60);
    shape.phase = between(0.0, 2.0 * kPi);
    sim::Scene scene;
    scene.name = "banana " + std::to_string(i + 1);
    TriangleMesh mesh = BananaMesh(shape);
    double lowest = 0.0;
    for (const Eigen::Vector3d& v : mesh.vertices) lowest = std::min(lowest, v.z());
    mesh = Transform(Pose::Translation({0, 0, -lowest}) * Pose::Rotation(Eigen::Vector3d::UnitZ(), between(0.0, 2.0 * kPi)), mesh);
    scene.bodies.push_back({"banana", std::move(mesh)});
    bananas.push_back(std::move(scene));
  }
  return bananas;
}

sim::Scene Tube() { return SingleGeon(GeonType::kCurvedCylinder, {17, 17, 85}, {0, 0}, 0.0085, {90, 0, 0}, "plastic tube"); }

}  // namespace geond::reproduce
