// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/picture/raster.h"
#include "core/picture/stroke_font.h"

namespace geond {

Canvas::Canvas(int width, int height, const Color& background)
    : columns(width), rows(height), light(static_cast<std::size_t>(width) * height, ToLight(background)) {}

void Canvas::DrawLine(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double width, const Color& color,
                      double opacity, const SurfaceLayer* depth) {
  const double radius = std::max(0.5 * width, 0.5);
  const Eigen::Vector2d a = from.head<2>(), along = to.head<2>() - a;
  const double length_squared = along.squaredNorm();
  const Color paint = ToLight(color);
  const auto low = [&](double x, double y, int n) {
    return std::clamp(static_cast<int>(std::floor(std::min(x, y) - radius)), 0, n);
  };
  const auto high = [&](double x, double y, int n) {
    return std::clamp(static_cast<int>(std::ceil(std::max(x, y) + radius)), 0, n);
  };
  const int last_column = high(from.x(), to.x(), columns), last_row = high(from.y(), to.y(), rows);
  for (int row = low(from.y(), to.y(), rows); row < last_row; ++row) {
    for (int column = low(from.x(), to.x(), columns); column < last_column; ++column) {
      const Eigen::Vector2d p = Eigen::Vector2d(column + 0.5, row + 0.5) - a;
      const double s = length_squared > 0.0 ? std::clamp(p.dot(along) / length_squared, 0.0, 1.0) : 0.0;
      if ((p - s * along).squaredNorm() > radius * radius) continue;
      if (depth != nullptr) {
        // Perspective: the inverse of depth is linear along the line. A little nearer, so that a line on a surface is
        // seen.
        const double at = 1.0 / ((1.0 - s) / from.z() + s / to.z());
        if (0.997 * at > depth->depth[depth->index(column, row)]) continue;
      }
      Color& pixel = at(column, row);
      pixel += static_cast<float>(opacity) * (paint - pixel);
    }
  }
}

void Canvas::FillRectangle(double left, double top, double right, double bottom, const Color& color) {
  const Color paint = ToLight(color);
  for (int row = std::max(0, static_cast<int>(std::lround(top))); row < std::min<int>(rows, std::lround(bottom));
       ++row) {
    for (int column = std::max(0, static_cast<int>(std::lround(left)));
         column < std::min<int>(columns, std::lround(right)); ++column) {
      at(column, row) = paint;
    }
  }
}

void Canvas::DrawText(std::string_view text, double x, double y, double height, const Color& color, double weight) {
  const double unit = height / 6.0;
  for (const Stroke& stroke : TextStrokes(text)) {
    for (std::size_t i = 0; i + 1 < stroke.size(); ++i) {
      const auto place = [&](const Eigen::Vector2d& p) {
        return Eigen::Vector3d(x + p.x() * unit, y + (p.y() - 6.0) * unit, 0.0);
      };
      DrawLine(place(stroke[i]), place(stroke[i + 1]), 0.75 * weight * unit, color);
    }
  }
}

void Canvas::Paste(const Canvas& other, int column, int row) {
  for (int r = 0; r < other.rows; ++r) {
    if (r + row < 0 || r + row >= rows) continue;
    for (int c = 0; c < other.columns; ++c) {
      if (c + column >= 0 && c + column < columns)
        at(c + column, r + row) = other.light[static_cast<std::size_t>(r) * other.columns + c];
    }
  }
}

Image Canvas::Reduced(int samples) const {
  Image image{columns / samples, rows / samples, {}};
  image.rgb.reserve(3 * static_cast<std::size_t>(image.columns) * image.rows);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      Color sum = Color::Zero();
      for (int r = 0; r < samples; ++r) {
        for (int c = 0; c < samples; ++c) {
          sum += light[static_cast<std::size_t>(row * samples + r) * columns + column * samples + c]
                     .cwiseMin(1.0f)
                     .cwiseMax(0.0f);
        }
      }
      const Color color = FromLight(sum / static_cast<float>(samples * samples));
      for (float c : color) image.rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0f * c)));
    }
  }
  return image;
}

}  // namespace geond
