// SPDX-License-Identifier: Apache-2.0
#include "core/surface/data_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"

namespace geond {
namespace {

constexpr int kNeighbors = 32;
constexpr double kNormalWidth = 0.45;            // rad, about: how much normals may differ and still count as one face
constexpr double kCreaseCosine = 0.90;           // cos 26 degrees: faces that differ by more meet in a crease

// A weighted mean of planes.
struct Face {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double weight = 0.0;
  double offset = 0.0;  // of the plane from x along the normal: the plane is normal.(y - x) = offset
};

}  // namespace

DataSurface::DataSurface(PointCloud cloud, double noise, int threads)
    : cloud_(std::move(cloud)), index_(std::make_unique<PointIndex>(cloud_.points)), noise_(noise) {
  std::vector<double> reaches((cloud_.size() + 15) / 16);
  ParallelFor(static_cast<std::ptrdiff_t>(reaches.size()), threads, 64, [&](std::ptrdiff_t i) {
    reaches[i] = std::sqrt(index_->Nearest(cloud_.points[16 * i], kNeighbors).back().second);
  });
  const auto middle = reaches.begin() + static_cast<std::ptrdiff_t>(reaches.size() / 2);
  if (!reaches.empty()) std::nth_element(reaches.begin(), middle, reaches.end());
  spacing_ = reaches.empty() ? 0.0 : *middle;
}

std::optional<DataSurface::Foot> DataSurface::Project(const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                                                      double attraction) const {
  const PointIndex::Neighbors neighbors = index_->Nearest(p, kNeighbors);
  if (neighbors.size() < 8 || neighbors[7].second > spacing_ * spacing_) return std::nullopt;
  const double reach = std::clamp(std::sqrt(neighbors.back().second), 0.5 * spacing_, 1.5 * spacing_);
  const double width = reach / 1.7;

  // The face whose normal is nearest to `start` among the points that `take` lets in, as seen from x.
  const auto find_face = [&](const Eigen::Vector3d& x, const Eigen::Vector3d& start, const auto& take) {
    Face face;
    face.normal = start;
    for (int iteration = 0; iteration < 4; ++iteration) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      face.weight = 0.0;
      for (const auto& [i, squared] : neighbors) {
        const Eigen::Vector3d& n = cloud_.normals[i];
        if (!take(n)) continue;
        const double turn = (n - face.normal).squaredNorm() / (kNormalWidth * kNormalWidth);
        const double w = std::exp(-(cloud_.points[i] - x).squaredNorm() / (2 * width * width) - turn);
        sum += w * n;
        face.weight += w;
      }
      if (!(sum.norm() > 1e-12)) return Face{};
      face.normal = sum.normalized();
    }
    double offset = 0.0, weights = 0.0;
    for (const auto& [i, squared] : neighbors) {
      const Eigen::Vector3d& n = cloud_.normals[i];
      if (!take(n)) continue;
      const double turn = (n - face.normal).squaredNorm() / (kNormalWidth * kNormalWidth);
      const double w = std::exp(-(cloud_.points[i] - x).squaredNorm() / (2 * width * width) - turn);
      offset += w * 0.5 * (n + face.normal).dot(cloud_.points[i] - x);
      weights += w;
    }
    face.offset = weights > 0.0 ? offset / weights : 0.0;
    return face;
  };
  const auto any = [&](const Eigen::Vector3d& n) { return n.dot(normal) > -0.2; };

  Eigen::Vector3d x = p;
  Face face;
  for (int iteration = 0; iteration < 2; ++iteration) {
    face = find_face(x, iteration == 0 ? normal : face.normal, any);
    if (!(face.weight > 0.3)) return std::nullopt;
    if (std::abs(face.offset) > reach) return std::nullopt;
    x += face.offset * face.normal;
  }
  Foot foot{x, face.normal, false, Eigen::Vector3d::Zero()};
  if (attraction <= 0.0) return foot;

  // A second face, of the points that do not agree.
  const auto other = [&](const Eigen::Vector3d& n) { return n.dot(face.normal) < kCreaseCosine && any(n); };
  Eigen::Vector3d start = Eigen::Vector3d::Zero();
  for (const auto& [i, squared] : neighbors) {
    if (other(cloud_.normals[i])) start += std::exp(-squared / (2 * width * width)) * cloud_.normals[i];
  }
  if (!(start.norm() > 0.1)) return foot;
  const Face second = find_face(x, start.normalized(), other);
  const double cosine = second.normal.dot(face.normal);
  if (second.weight < 0.12 * face.weight || cosine > kCreaseCosine || cosine < -0.9) return foot;
  // The nearest point of the line in which the two planes meet: x + a n + b m with n.(..) = 0 and m.(..) = offset.
  const double b = second.offset / (1.0 - cosine * cosine), a = -b * cosine;
  const Eigen::Vector3d step = a * face.normal + b * second.normal;
  if (step.norm() > attraction) return foot;
  foot.point = x + step;
  foot.on_crease = true;
  foot.along = face.normal.cross(second.normal).normalized();
  foot.normal = (face.normal + second.normal).normalized();
  return foot;
}

PointCloud CreaseAwareCloud(std::span<const RangeView> views, int threads) {
  PointCloud cloud;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const RangeView& view = views[v];
    std::vector<Eigen::Vector3f> normals = view.normals_S;
    const double slack = std::max(3.0 * view.sensor.depth_noise, 1e-4);
    ParallelFor(view.image.rows, threads, 4, [&](std::ptrdiff_t row_long) {
      const int row = static_cast<int>(row_long);
      for (int column = 0; column < view.image.columns; ++column) {
        const std::size_t pixel = view.image.index(column, row);
        if (!view.IsObject(pixel) || !view.normals_S[pixel].allFinite() || view.normal_residuals.empty()) continue;
        const Eigen::Vector3d p = Unproject(view.sensor, column, row, view.image.depth[pixel]);
        const double own = view.normal_residuals[pixel];
        double best = own / 1.4;  // not for a little
        for (int dv = -2; dv <= 2; ++dv) {
          for (int du = -2; du <= 2; ++du) {
            if (!view.image.contains(column + du, row + dv)) continue;
            const std::size_t other = view.image.index(column + du, row + dv);
            if (!view.IsObject(other) || !view.normals_S[other].allFinite() || !(view.normal_residuals[other] < best)) continue;
            const Eigen::Vector3d q = Unproject(view.sensor, column + du, row + dv, view.image.depth[other]);
            if (std::abs(view.normals_S[other].cast<double>().dot(p - q)) > slack) continue;
            best = view.normal_residuals[other];
            normals[pixel] = view.normals_S[other];
          }
        }
      }
    });
    for (int row = 0; row < view.image.rows; ++row) {
      for (int column = 0; column < view.image.columns; ++column) {
        const std::size_t pixel = view.image.index(column, row);
        if (!view.IsObject(pixel) || !normals[pixel].allFinite() || !std::isfinite(view.image.depth[pixel])) continue;
        cloud.points.push_back(view.X_TS * Unproject(view.sensor, column, row, view.image.depth[pixel]));
        cloud.normals.push_back(view.X_TS.Rotate(normals[pixel].cast<double>().normalized()));
        cloud.views.push_back(static_cast<int>(v));
      }
    }
  }
  return cloud;
}

}  // namespace geond
