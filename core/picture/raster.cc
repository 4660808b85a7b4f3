// SPDX-License-Identifier: Apache-2.0
#include "core/picture/raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace geond {
namespace {

// A corner of a triangle on its way to the raster.
struct Corner {
  Eigen::Vector3d pixel;   // column, row, depth
  Eigen::Vector3f normal;  // in the eye's frame
  Color light;
};

struct FlatTriangle {
  std::array<Corner, 3> corners;
  float opacity;
  bool outlined;
};

struct Disc {
  Eigen::Vector3d pixel;   // of the centre
  Eigen::Vector3f normal;  // in the eye's frame; zero: a ball
  Color light;
  double radius;  // pixels
  float opacity;
};

// For each vertex the corners (3 t + k) at it, one vertex after the other.
struct CornersOfVertices {
  explicit CornersOfVertices(const TriangleMesh& mesh)
      : begin(mesh.vertices.size() + 1, 0), corners(3 * mesh.triangles.size()) {
    for (const auto& t : mesh.triangles) {
      for (int v : t) ++begin[v + 1];
    }
    for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) corners[next[mesh.triangles[t][k]]++] = 3 * t + k;
    }
  }
  std::vector<std::size_t> begin, corners;
};

// A normal for each corner: the mean over the triangles at the vertex that bend less than the crease from this one.
std::vector<Eigen::Vector3d> CornerNormals(const TriangleMesh& mesh, double crease) {
  std::vector<Eigen::Vector3d> areas(mesh.triangles.size());
  for (std::size_t t = 0; t < areas.size(); ++t) areas[t] = TriangleAreaVector(mesh, static_cast<int>(t));
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(mesh);
  const CornersOfVertices at(mesh);
  const double cosine = std::cos(crease);
  std::vector<Eigen::Vector3d> result(3 * mesh.triangles.size());
  for (std::size_t v = 0; v + 1 < at.begin.size(); ++v) {
    // Points where very many triangles meet (the poles of a fan) would take their square.
    const bool many = at.begin[v + 1] - at.begin[v] > 64;
    for (std::size_t i = at.begin[v]; i < at.begin[v + 1]; ++i) {
      const std::size_t t = at.corners[i] / 3;
      Eigen::Vector3d sum = many ? areas[t] : Eigen::Vector3d::Zero();
      for (std::size_t j = at.begin[v]; !many && j < at.begin[v + 1]; ++j) {
        const std::size_t other = at.corners[j] / 3;
        if (other == t || (crease > 0.0 && normals[t].dot(normals[other]) >= cosine)) sum += areas[other];
      }
      result[at.corners[i]] = sum.stableNormalized();
    }
  }
  return result;
}

void AddTriangles(const Scene::Mesh& item, const View& view, std::vector<FlatTriangle>& triangles) {
  const TriangleMesh& mesh = item.mesh;
  const MeshStyle& style = item.style;
  const std::vector<Eigen::Vector3d> normals = CornerNormals(mesh, style.crease_angle);
  const Color plain = ToLight(style.color);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    FlatTriangle triangle{{}, static_cast<float>(style.opacity), style.outline};
    bool visible = true;
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles[t][k];
      Corner& corner = triangle.corners[k];
      corner.pixel = view.Project(mesh.vertices[v]);
      visible = visible && corner.pixel.z() > view.nearest();
      corner.normal = (view.rotation() * normals[3 * t + k]).cast<float>();
      corner.light = !style.triangle_colors.empty() ? ToLight(style.triangle_colors[t])
                     : !style.vertex_colors.empty() ? ToLight(style.vertex_colors[v])
                                                    : plain;
    }
    if (visible) triangles.push_back(triangle);
  }
}

// How far points on a surface lie apart: for some of them, the disc that reaches to the sixth of the others holds six.
double TypicalSpacing(const PointCloud& cloud) {
  constexpr std::size_t kProbed = 96, kNeighbors = 6;
  if (cloud.size() <= kNeighbors) return 1e-3;
  std::vector<double> spacings, squared(cloud.size());
  for (std::size_t k = 0; k < kProbed; ++k) {
    const Eigen::Vector3d& p = cloud.points[k * cloud.size() / kProbed];
    for (std::size_t i = 0; i < cloud.size(); ++i) squared[i] = (cloud.points[i] - p).squaredNorm();
    std::nth_element(squared.begin(), squared.begin() + kNeighbors, squared.end());
    spacings.push_back(std::sqrt(squared[kNeighbors] * 3.14159265 / kNeighbors));
  }
  std::nth_element(spacings.begin(), spacings.begin() + kProbed / 2, spacings.end());
  return std::max(spacings[kProbed / 2], 1e-4 * BoundingBox(cloud.points).sizes().norm());
}

void AddDiscs(const Scene::Cloud& item, const View& view, std::vector<Disc>& discs) {
  const PointCloud& cloud = item.cloud;
  const double radius =
      item.style.radius > 0.0 ? item.style.radius : (cloud.has_normals() ? 0.95 : 0.65) * TypicalSpacing(cloud);
  const Color plain = ToLight(item.style.color);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Disc disc;
    disc.pixel = view.Project(cloud.points[i]);
    if (disc.pixel.z() <= view.nearest()) continue;
    disc.normal = Eigen::Vector3f::Zero();
    if (cloud.has_normals()) {
      disc.normal = (view.rotation() * cloud.normals[i]).cast<float>();
      if (disc.normal.dot(view.ToEye(cloud.points[i]).cast<float>()) > 0.0f) disc.normal = -disc.normal;
    }
    disc.light = item.style.point_colors.empty() ? plain : ToLight(item.style.point_colors[i]);
    disc.radius = std::max(radius * view.focal() / disc.pixel.z(), 0.75);
    disc.opacity = static_cast<float>(item.style.opacity);
    discs.push_back(disc);
  }
}

// The rows [first, last) of a layer; each band is drawn by one thread, with everything in the order of the scene.
class Band {
 public:
  Band(SurfaceLayer& layer, const View& view, int first, int last)
      : layer_(layer), view_(view), first_(first), last_(last) {}

  void Draw(const FlatTriangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    const double top = std::min({a.pixel.y(), b.pixel.y(), c.pixel.y()}),
                 bottom = std::max({a.pixel.y(), b.pixel.y(), c.pixel.y()});
    if (bottom < first_ || top > last_) return;
    const double left = std::min({a.pixel.x(), b.pixel.x(), c.pixel.x()}),
                 right = std::max({a.pixel.x(), b.pixel.x(), c.pixel.x()});
    const double area = Cross(a.pixel, b.pixel, c.pixel.x(), c.pixel.y());
    if (area == 0.0 || right < 0 || left > layer_.columns) return;
    const bool back = area > 0.0;  // rows run down: counter-clockwise triangles have negative area
    const int row_end = RowBound(bottom + 1), column_end = ColumnBound(right + 1);
    for (int row = RowBound(top); row < row_end; ++row) {
      for (int column = ColumnBound(left); column < column_end; ++column) {
        const double x = column + 0.5, y = row + 0.5;
        const double wa = Cross(b.pixel, c.pixel, x, y) / area, wb = Cross(c.pixel, a.pixel, x, y) / area,
                     wc = 1.0 - wa - wb;
        if (wa < 0.0 || wb < 0.0 || wc < 0.0) continue;
        // Perspective: weights over depth.
        const double ia = wa / a.pixel.z(), ib = wb / b.pixel.z(), ic = wc / c.pixel.z(), depth = 1.0 / (ia + ib + ic);
        const std::size_t i = layer_.index(column, row);
        if (!(depth < layer_.depth[i])) continue;
        const auto fa = static_cast<float>(ia * depth), fb = static_cast<float>(ib * depth),
                   fc = static_cast<float>(ic * depth);
        Eigen::Vector3f normal = (fa * a.normal + fb * b.normal + fc * c.normal).normalized();
        Color light = fa * a.light + fb * b.light + fc * c.light;
        if (back) {
          normal = -normal;
          light *= 0.55f;  // the inside of an open surface
        }
        Put(i, static_cast<float>(depth), normal, light, triangle.opacity, triangle.outlined);
      }
    }
  }

  void Draw(const Disc& disc) {
    const double r = disc.radius;
    if (disc.pixel.y() + r < first_ || disc.pixel.y() - r > last_) return;
    const int row_end = RowBound(disc.pixel.y() + r + 1), column_end = ColumnBound(disc.pixel.x() + r + 1);
    const bool flat = disc.normal.squaredNorm() > 0.0f;
    const double metres = disc.pixel.z() / view_.focal();  // a pixel
    const double nz = std::max(0.3f, disc.normal.z());
    for (int row = RowBound(disc.pixel.y() - r); row < row_end; ++row) {
      for (int column = ColumnBound(disc.pixel.x() - r); column < column_end; ++column) {
        const double x = column + 0.5 - disc.pixel.x(), y = disc.pixel.y() - row - 0.5;
        double nearer = 0.0;  // pixels towards the eye
        Eigen::Vector3f normal = disc.normal;
        if (flat) {
          nearer = -(disc.normal.x() * x + disc.normal.y() * y) / nz;
          if (x * x + y * y + nearer * nearer > r * r) continue;
        } else {
          const double squared = r * r - x * x - y * y;
          if (squared < 0.0) continue;
          nearer = std::sqrt(squared);
          normal = Eigen::Vector3d(x / r, y / r, nearer / r).cast<float>();
        }
        const double depth = disc.pixel.z() - nearer * metres;
        const std::size_t i = layer_.index(column, row);
        if (depth < layer_.depth[i]) Put(i, static_cast<float>(depth), normal, disc.light, disc.opacity, false);
      }
    }
  }

 private:
  static double Cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double x, double y) {
    return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
  }
  int RowBound(double row) const {
    return static_cast<int>(std::clamp(std::floor(row), double(first_), double(last_)));
  }
  int ColumnBound(double column) const {
    return static_cast<int>(std::clamp(std::floor(column), 0.0, double(layer_.columns)));
  }
  void Put(std::size_t i, float depth, const Eigen::Vector3f& normal, const Color& light, float opacity,
           bool outlined) {
    layer_.depth[i] = depth;
    layer_.normal[i] = normal;
    layer_.color[i] = light;
    layer_.opacity[i] = opacity;
    layer_.outlined[i] = outlined ? 1 : 0;
  }

  SurfaceLayer& layer_;
  const View& view_;
  int first_, last_;
};

}  // namespace

SurfaceLayer::SurfaceLayer(int width, int height)
    : columns(width),
      rows(height),
      depth(static_cast<std::size_t>(width) * height, std::numeric_limits<float>::infinity()),
      normal(depth.size(), Eigen::Vector3f::UnitZ()),
      color(depth.size(), Color::Zero()),
      opacity(depth.size(), 0.0f),
      outlined(depth.size(), 0) {}

void DrawSurfaces(const Scene& scene, const View& view, bool opaque, int threads, SurfaceLayer& layer) {
  std::vector<FlatTriangle> triangles;
  std::vector<Disc> discs;
  for (const Scene::Mesh& mesh : scene.meshes) {
    if ((mesh.style.opacity >= 1.0) == opaque) AddTriangles(mesh, view, triangles);
  }
  for (const Scene::Cloud& cloud : scene.clouds) {
    if ((cloud.style.opacity >= 1.0) == opaque) AddDiscs(cloud, view, discs);
  }
  constexpr int kBandRows = 64;
  ParallelFor((layer.rows + kBandRows - 1) / kBandRows, threads, 1, [&](std::ptrdiff_t b) {
    const int first = static_cast<int>(b) * kBandRows;
    Band band(layer, view, first, std::min(layer.rows, first + kBandRows));
    for (const FlatTriangle& triangle : triangles) band.Draw(triangle);
    for (const Disc& disc : discs) band.Draw(disc);
  });
}

}  // namespace geond
