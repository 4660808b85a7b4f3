// SPDX-License-Identifier: Apache-2.0
#include "core/picture/shading.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"

namespace geond {
namespace {

constexpr int kTile = 4;  // pixels a side within which the directions differ; the blur is as large
constexpr int kProbes = 12;

// Directions over the hemisphere about z with lengths from short to long, turned a little for each pixel of a tile.
std::array<Eigen::Vector3f, kProbes> Probes(int turn) {
  std::array<Eigen::Vector3f, kProbes> probes;
  for (int k = 0; k < kProbes; ++k) {
    const double share = (k + 0.5) / kProbes;
    const double angle = 2.39996322973 * k + turn * 2.0 * 3.14159265358979 / (kTile * kTile);
    const double height = std::sqrt(1.0 - 0.92 * std::fmod(share * 5.0, 1.0)), flat = std::sqrt(1.0 - height * height);
    probes[k] =
        (Eigen::Vector3d(flat * std::cos(angle), flat * std::sin(angle), height) * (0.08 + 0.92 * share * share))
            .cast<float>();
  }
  return probes;
}

// The openness of one pixel, as its probes say.
float ProbedOpenness(const SurfaceLayer& layer, const View& view, double radius, int column, int row,
                     const std::array<Eigen::Vector3f, kProbes>& probes) {
  const std::size_t i = layer.index(column, row);
  const Eigen::Vector3d at = view.EyePoint(column + 0.5, row + 0.5, layer.depth[i]);
  const Eigen::Vector3f& n = layer.normal[i];
  const Eigen::Vector3f x = n.unitOrthogonal(), y = n.cross(x);
  float hidden = 0.0f;
  for (const Eigen::Vector3f& probe : probes) {
    const Eigen::Vector3d p = at + radius * (probe.x() * x + probe.y() * y + (probe.z() + 0.03f) * n).cast<double>();
    const double depth = -p.z();
    const int u = static_cast<int>(std::floor(0.5 * layer.columns + view.focal() * p.x() / depth));
    const int v = static_cast<int>(std::floor(0.5 * layer.rows - view.focal() * p.y() / depth));
    if (u < 0 || v < 0 || u >= layer.columns || v >= layer.rows) continue;
    const double nearer = depth - layer.depth[layer.index(u, v)];
    // What lies far before the surface does not shade it.
    if (nearer > 0.01 * radius) hidden += static_cast<float>(std::clamp(1.6 - nearer / radius, 0.0, 1.0));
  }
  return 1.0f - hidden / kProbes;
}

}  // namespace

std::vector<float> Openness(const SurfaceLayer& layer, const View& view, double radius, int samples, int threads) {
  std::array<std::array<Eigen::Vector3f, kProbes>, kTile * kTile> tiles;
  for (int turn = 0; turn < kTile * kTile; ++turn) tiles[turn] = Probes(turn * 7 % (kTile * kTile));
  const int columns = layer.columns / samples, rows = layer.rows / samples, middle = samples / 2;
  std::vector<float> probed(static_cast<std::size_t>(columns) * rows, 1.0f);
  ParallelFor(rows, threads, 8, [&](std::ptrdiff_t r) {
    for (int c = 0; c < columns; ++c) {
      const int column = c * samples + middle, row = static_cast<int>(r) * samples + middle;
      if (!std::isfinite(layer.depth[layer.index(column, row)])) continue;
      probed[r * columns + c] =
          ProbedOpenness(layer, view, radius, column, row, tiles[(r % kTile) * kTile + c % kTile]);
    }
  });

  std::vector<float> smooth(layer.depth.size(), 1.0f);
  ParallelFor(layer.rows, threads, 16, [&](std::ptrdiff_t row) {
    for (int column = 0; column < layer.columns; ++column) {
      const std::size_t i = layer.index(column, static_cast<int>(row));
      const float depth = layer.depth[i];
      if (!std::isfinite(depth)) continue;
      float sum = 0.0f;
      int n = 0;
      const int c0 = column / samples - kTile / 2, r0 = static_cast<int>(row) / samples - kTile / 2;
      for (int r = std::max(0, r0); r < std::min(rows, r0 + kTile); ++r) {
        for (int c = std::max(0, c0); c < std::min(columns, c0 + kTile); ++c) {
          const float other = layer.depth[layer.index(c * samples + middle, r * samples + middle)];
          if (!(std::abs(other - depth) < 0.3f * static_cast<float>(radius))) continue;
          sum += probed[static_cast<std::size_t>(r) * columns + c];
          ++n;
        }
      }
      if (n > 0) smooth[i] = sum / static_cast<float>(n);
    }
  });
  return smooth;
}

Color Shade(const Color& surface, const Eigen::Vector3f& normal, const Eigen::Vector3f& up, float openness) {
  static const Eigen::Vector3f kSun = Eigen::Vector3f(-0.42f, 0.62f, 0.66f).normalized();
  static const Eigen::Vector3f kLamp = Eigen::Vector3f(0.65f, 0.05f, 0.75f).normalized();
  static const Eigen::Vector3f kHalf = (kSun + Eigen::Vector3f::UnitZ()).normalized();
  const float sun = std::max(0.0f, normal.dot(kSun)), lamp = std::max(0.0f, normal.dot(kLamp));
  const float sky = 0.5f + 0.5f * normal.dot(up);
  const float open = openness * openness;
  const float light = 0.62f * sun * (0.35f + 0.65f * open) + 0.16f * lamp * openness + (0.20f + 0.22f * sky) * open;
  const float gloss = 0.10f * std::pow(std::max(0.0f, normal.dot(kHalf)), 36.0f) * open;
  const float rim = 0.10f * std::pow(1.0f - std::clamp(normal.z(), 0.0f, 1.0f), 3.0f) * open;
  return light * surface + Color::Constant(gloss + rim);
}

std::optional<GroundShadow> GroundShadow::Of(const Scene& scene, const Camera& camera) {
  Eigen::AlignedBox3d box;
  for (const Scene::Mesh& mesh : scene.meshes) {
    for (const Eigen::Vector3d& p : mesh.mesh.vertices) box.extend(p);
  }
  for (const Scene::Cloud& cloud : scene.clouds) {
    for (const Eigen::Vector3d& p : cloud.cloud.points) box.extend(p);
  }
  if (box.isEmpty() || camera.elevation < 0.05) return std::nullopt;

  GroundShadow shadow;
  shadow.ground_ = box.min().z();
  const double flat = std::max({box.sizes().x(), box.sizes().y(), 0.3 * box.sizes().z(), 1e-9});
  const double side = 1.9 * flat;
  shadow.cell_ = side / kCells;
  shadow.left_ = box.center().x() - 0.5 * side;
  shadow.front_ = box.center().y() - 0.5 * side;
  // The lowest thing over each cell, as a share of the object's size: what is low shades more.
  const double reach = 0.6 * flat;
  std::vector<float> cover(static_cast<std::size_t>(kCells) * kCells, 0.0f);
  const auto add = [&](const Eigen::Vector3d& p) {
    const int u = static_cast<int>((p.x() - shadow.left_) / shadow.cell_),
              v = static_cast<int>((p.y() - shadow.front_) / shadow.cell_);
    if (u < 0 || v < 0 || u >= kCells || v >= kCells) return;
    float& cell = cover[static_cast<std::size_t>(v) * kCells + u];
    cell = std::max(cell, static_cast<float>(1.0 / (1.0 + 3.0 * (p.z() - shadow.ground_) / reach)));
  };
  for (const Scene::Mesh& mesh : scene.meshes) {
    for (std::size_t t = 0; t < mesh.mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.mesh.triangles[t];
      const Eigen::Vector3d &p = mesh.mesh.vertices[a], q = mesh.mesh.vertices[b] - p, r = mesh.mesh.vertices[c] - p;
      const double longest = std::max({q.head<2>().norm(), r.head<2>().norm(), (q - r).head<2>().norm()});
      const int n = std::clamp(static_cast<int>(std::ceil(longest / (0.7 * shadow.cell_))), 1, 2 * kCells);
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; i + j <= n; ++j) add(p + q * i / n + r * j / n);
      }
    }
  }
  for (const Scene::Cloud& cloud : scene.clouds) {
    for (const Eigen::Vector3d& p : cloud.cloud.points) add(p);
  }
  // Three means over a window are as good as a bell.
  for (int round = 0; round < 3; ++round) {
    for (const bool across : {true, false}) {
      std::vector<float> next(cover.size(), 0.0f);
      constexpr int kReach = 6;
      for (int v = 0; v < kCells; ++v) {
        for (int u = 0; u < kCells; ++u) {
          float sum = 0.0f;
          for (int d = -kReach; d <= kReach; ++d) {
            const int x = across ? u + d : u, y = across ? v : v + d;
            if (x >= 0 && y >= 0 && x < kCells && y < kCells) sum += cover[static_cast<std::size_t>(y) * kCells + x];
          }
          next[static_cast<std::size_t>(v) * kCells + u] = sum / (2 * kReach + 1);
        }
      }
      cover = std::move(next);
    }
  }
  shadow.dark_ = std::move(cover);
  return shadow;
}

float GroundShadow::At(const View& view, double column, double row) const {
  const Eigen::Vector3d direction = view.rotation().transpose() * view.EyePoint(column, row, 1.0);
  if (direction.z() > -1e-3) return 0.0f;
  const Eigen::Vector3d p = view.eye() + direction * ((ground_ - view.eye().z()) / direction.z());
  const double x = (p.x() - left_) / cell_ - 0.5, y = (p.y() - front_) / cell_ - 0.5;
  const int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  if (u < 0 || v < 0 || u + 1 >= kCells || v + 1 >= kCells) return 0.0f;
  const auto fx = static_cast<float>(x - u), fy = static_cast<float>(y - v);
  const float* cell = &dark_[static_cast<std::size_t>(v) * kCells + u];
  const float dark =
      (1 - fy) * ((1 - fx) * cell[0] + fx * cell[1]) + fy * ((1 - fx) * cell[kCells] + fx * cell[kCells + 1]);
  // Nothing of it may end at the picture's edge.
  const double edge = std::min({column, row, view.columns() - column, view.rows() - row}) /
                      (0.12 * std::min(view.columns(), view.rows()));
  const auto fade = static_cast<float>(std::clamp(edge, 0.0, 1.0));
  return 0.42f * dark * fade * fade * (3.0f - 2.0f * fade);
}

}  // namespace geond
