// SPDX-License-Identifier: Apache-2.0
#include "core/picture/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/base/printed.h"
#include "core/picture/draw_scene.h"
#include "core/picture/shading.h"
#include "core/picture/stroke_font.h"

namespace geond {
namespace {

void CheckStyles(const Scene& scene) {
  for (const Scene::Mesh& item : scene.meshes) {
    CheckMesh(item.mesh);
    const MeshStyle& style = item.style;
    if ((!style.triangle_colors.empty() && style.triangle_colors.size() != item.mesh.triangles.size()) ||
        (!style.vertex_colors.empty() && style.vertex_colors.size() != item.mesh.vertices.size())) {
      throw std::invalid_argument("a mesh wants one colour a triangle, or one a vertex");
    }
  }
  for (const Scene::Cloud& item : scene.clouds) {
    if (!item.style.point_colors.empty() && item.style.point_colors.size() != item.cloud.size()) {
      throw std::invalid_argument("a cloud wants one colour a point");
    }
  }
}

// Whether the surface ends beside this pixel: a neighbour `step` pixels off is much farther away, or nothing.
bool IsOutline(const SurfaceLayer& layer, int column, int row, int step, float jump) {
  const float depth = layer.depth[layer.index(column, row)];
  constexpr int kOffsets[][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& [du, dv] : kOffsets) {
    const int u = column + step * du, v = row + step * dv;
    if (u < 0 || v < 0 || u >= layer.columns || v >= layer.rows) continue;
    if (layer.depth[layer.index(u, v)] > depth + jump) return true;
  }
  return false;
}

}  // namespace

Canvas DrawScene(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  CheckStyles(scene);
  const int columns = options.columns * options.samples, rows = options.rows * options.samples;
  const View view(camera, columns, rows);
  SurfaceLayer solid(columns, rows), clear(columns, rows);
  DrawSurfaces(scene, view, true, options.threads, solid);
  DrawSurfaces(scene, view, false, options.threads, clear);

  const double size = 2.0 * camera.distance * std::tan(0.5 * camera.field_of_view);  // m across the picture
  std::vector<float> open_solid(solid.depth.size(), 1.0f), open_clear = open_solid;
  if (options.occlusion) {
    open_solid = Openness(solid, view, 0.06 * size, options.samples, options.threads);
    open_clear = Openness(clear, view, 0.06 * size, options.samples, options.threads);
  }
  std::optional<GroundShadow> shadow;
  if (options.ground_shadow) shadow = GroundShadow::Of(scene, camera);

  Canvas canvas(columns, rows, options.background);
  const Eigen::Vector3f up = (view.rotation() * Eigen::Vector3d::UnitZ()).cast<float>();
  const auto jump = static_cast<float>(0.02 * size);
  ParallelFor(rows, options.threads, 16, [&](std::ptrdiff_t r) {
    const int row = static_cast<int>(r);
    for (int column = 0; column < columns; ++column) {
      const std::size_t i = solid.index(column, row);
      Color& pixel = canvas.light[i];
      const auto outline = [&](const SurfaceLayer& layer) {
        return layer.outlined[i] != 0 && IsOutline(layer, column, row, options.samples, jump) ? 0.45f : 1.0f;
      };
      if (std::isfinite(solid.depth[i])) {
        pixel = outline(solid) * Shade(solid.color[i], solid.normal[i], up, open_solid[i]);
      } else if (shadow) {
        pixel *= 1.0f - shadow->At(view, column + 0.5, row + 0.5);
      }
      if (clear.depth[i] < solid.depth[i]) {
        // Glass shows most of itself where it is seen from the side.
        const float side = 1.0f - std::clamp(clear.normal[i].z(), 0.0f, 1.0f);
        const float opacity = clear.opacity[i] + (1.0f - clear.opacity[i]) * 0.7f * side * side * side;
        const Color light = outline(clear) * Shade(clear.color[i], clear.normal[i], up, open_clear[i]);
        pixel += opacity * (light - pixel);
      }
    }
  });

  for (const Scene::Lines& lines : scene.lines) {
    for (const Segment& segment : lines.segments) {
      const Eigen::Vector3d from = view.Project(segment.from), to = view.Project(segment.to);
      if (from.z() <= view.nearest() || to.z() <= view.nearest()) continue;
      canvas.DrawLine(from, to, lines.style.width * options.samples, lines.style.color, 1.0, &solid);
    }
  }
  const double letter = TextHeight(options);
  for (const Scene::Label& label : scene.labels) {
    const Eigen::Vector3d at = view.Project(label.at);
    if (at.z() <= view.nearest()) continue;
    const double x = at.x() - 0.5 * TextWidth(label.text) * letter / 6.0, y = at.y() + 0.5 * letter;
    canvas.DrawText(label.text, x, y, letter, Color::Ones(), 3.6);
    canvas.DrawText(label.text, x, y, letter, label.color, 1.3);
  }
  if (options.axes) DrawAxes(canvas, view, options);
  if (options.scale_bar) DrawScaleBar(canvas, view, camera, options);
  return canvas;
}

double TextHeight(const RenderOptions& options) {
  return std::clamp(0.019 * std::min(options.columns, options.rows), 7.0, 18.0) * options.samples;
}

void DrawAxes(Canvas& canvas, const View& view, const RenderOptions& options) {
  const double letter = TextHeight(options), length = 3.2 * letter;
  const Eigen::Vector2d origin(4.0 * letter, canvas.rows - 4.0 * letter);
  const Color colors[] = {{0.80f, 0.22f, 0.20f}, {0.20f, 0.56f, 0.24f}, {0.20f, 0.36f, 0.78f}};
  // Those that point away first.
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return view.rotation()(2, a) < view.rotation()(2, b); });
  for (int axis : order) {
    const Eigen::Vector3d direction = view.rotation().col(axis);
    const Eigen::Vector2d tip = origin + length * Eigen::Vector2d(direction.x(), -direction.y());
    canvas.DrawLine({origin.x(), origin.y(), 0}, {tip.x(), tip.y(), 0}, 0.22 * letter, colors[axis]);
    const Eigen::Vector2d at = origin + (length + 0.9 * letter) * Eigen::Vector2d(direction.x(), -direction.y());
    if (direction.head<2>().norm() < 0.2) continue;
    const char name[] = {static_cast<char>('x' + axis), '\0'};
    canvas.DrawText(name, at.x() - 0.3 * letter, at.y() + 0.35 * letter, 0.9 * letter, colors[axis], 1.3);
  }
}

void DrawScaleBar(Canvas& canvas, const View& view, const Camera& camera, const RenderOptions& options) {
  const double pixels_per_m = view.focal() / camera.distance;  // at the target
  const double wanted = 0.24 * canvas.columns / pixels_per_m;
  double length = std::pow(10.0, std::floor(std::log10(wanted)));
  for (const double step : {5.0, 2.0}) {
    if (step * length <= wanted) {
      length *= step;
      break;
    }
  }
  const double letter = TextHeight(options), pixels = length * pixels_per_m;
  const double right = canvas.columns - 2.0 * letter, y = canvas.rows - 2.0 * letter;
  const Color ink = Color::Constant(0.25f);
  canvas.FillRectangle(right - pixels, y - 0.14 * letter, right, y + 0.14 * letter, ink);
  for (const double x : {right - pixels, right}) {
    canvas.FillRectangle(x - 0.1 * letter, y - 0.5 * letter, x + 0.1 * letter, y + 0.5 * letter, ink);
  }
  const std::string text = Printed("%g mm", length * 1e3);
  canvas.DrawText(text, right - 0.5 * pixels - 0.5 * TextWidth(text) * letter / 6.0, y - 0.7 * letter, letter, ink);
}

Image Render(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  if (options.columns < 16 || options.rows < 16 || options.columns > 8192 || options.rows > 8192 ||
      options.samples < 1 || options.samples > 4) {
    throw std::invalid_argument("Render: a picture has 16 to 8192 columns and rows, and 1 to 4 samples");
  }
  return DrawScene(scene, camera, options).Reduced(options.samples);
}

}  // namespace geond
