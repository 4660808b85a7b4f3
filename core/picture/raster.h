// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/picture/color.h"
#include "core/picture/image.h"
#include "core/picture/scene.h"
#include "core/picture/view.h"

namespace geond {

// The nearest surface of every pixel.
struct SurfaceLayer {
  SurfaceLayer(int columns, int rows);
  int columns, rows;
  std::vector<float> depth;             // m from the eye along the line of sight; infinite: nothing
  std::vector<Eigen::Vector3f> normal;  // in the eye's frame, towards the eye
  std::vector<Color> color;             // as light
  std::vector<float> opacity;           // 1: nothing shines through
  std::vector<std::uint8_t> outlined;   // 1: part of a mesh that wants an outline
  std::size_t index(int column, int row) const { return static_cast<std::size_t>(row) * columns + column; }
};

// What of a scene is opaque, or what is not, drawn into the layer.
void DrawSurfaces(const Scene& scene, const View& view, bool opaque, int threads, SurfaceLayer& layer);

// A picture in the making, in amounts of light.
struct Canvas {
  Canvas(int width, int height, const Color& background);
  int columns, rows;
  std::vector<Color> light;
  Color& at(int column, int row) { return light[static_cast<std::size_t>(row) * columns + column]; }

  // A line with round ends, `width` pixels wide. With `depth` of a layer it is hidden where that is nearer than the
  // line, whose ends then carry their own depth as third coordinate.
  void DrawLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double width, const Color& color,
                double opacity = 1.0, const SurfaceLayer* depth = nullptr);
  void FillRectangle(double left, double top, double right, double bottom, const Color& color);
  // Text whose capitals are `height` pixels high, its left end at x, standing on the line y; bold from weight 1.5 on.
  void DrawText(std::string_view text, double x, double y, double height, const Color& color, double weight = 1.0);
  void Paste(const Canvas& other, int column, int row);
  // Each square of samples x samples pixels becomes one of the image.
  Image Reduced(int samples) const;
};

}  // namespace geond
