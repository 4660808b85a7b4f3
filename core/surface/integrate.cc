// SPDX-License-Identifier: Apache-2.0
#include "core/surface/integrate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/progress.h"

namespace geond {
namespace {

// A range datum as the algorithm sees it.
struct Datum {
  int pixel;
  Eigen::Vector3d p_T;
  double cosine;    // of the angle between normal and line of sight
  double residual;  // of the normal fit, m; infinite if unknown
  bool kept = true;
};

struct DataOfView {
  std::vector<Datum> data;
  std::vector<int> at_pixel;  // index into data, -1 none
  Pose X_ST;
};

DataOfView Gather(const RangeView& view) {
  DataOfView result;
  const std::size_t n_pixels = view.image.depth.size();
  result.at_pixel.assign(n_pixels, -1);
  result.X_ST = Inverse(view.X_TS);
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      const std::size_t pixel = view.image.index(column, row);
      if (!view.IsObject(pixel) || !view.normals_S[pixel].allFinite() || !std::isfinite(view.image.depth[pixel])) continue;
      Datum datum;
      datum.pixel = static_cast<int>(pixel);
      datum.p_T = view.X_TS * Unproject(view.sensor, column, row, view.image.depth[pixel]);
      datum.cosine = -view.normals_S[pixel].cast<double>().normalized().dot(RayDirection(view.sensor, column, row));
      const float residual = view.normal_residuals.empty() ? std::numeric_limits<float>::infinity() : view.normal_residuals[pixel];
      datum.residual = std::isfinite(residual) ? residual : std::numeric_limits<double>::infinity();
      result.at_pixel[pixel] = static_cast<int>(result.data.size());
      result.data.push_back(datum);
    }
  }
  return result;
}

// The three criteria in their order; false also if nothing tells the two apart, so that the earlier one stays.
bool IsBetter(const Datum& later, const Datum& earlier, const IntegrateOptions& options) {
  if (std::abs(later.cosine - earlier.cosine) > options.cosine_margin) return later.cosine > earlier.cosine;
  return later.residual < earlier.residual * (1.0 - options.residual_margin);
}

double Threshold(const RangeView& view, const Datum& datum, const IntegrateOptions& options) {
  if (options.distance > 0.0) return options.distance;
  const bool perspective = view.sensor.projection == SensorModel::Projection::kPerspective;
  const double depth = perspective ? view.image.depth[datum.pixel] : 1.0;
  const double pitch = depth / std::min(std::abs(view.sensor.focal_u), std::abs(view.sensor.focal_v));
  return 1.5 * pitch + 3.0 * view.sensor.depth_noise;
}

// The datum of view n that shows the same point of the surface as `datum`, or -1.
int RedundantIn(const RangeView& view_n, const DataOfView& data_n, const Datum& datum, double threshold) {
  const auto at = Project(view_n.sensor, data_n.X_ST * datum.p_T);
  // Compared as floating point: a point far outside the image need not fit into an int.
  if (!at || !(at->x() > -0.5 && at->y() > -0.5 && at->x() < view_n.image.columns - 0.5 &&
               at->y() < view_n.image.rows - 0.5)) {
    return -1;
  }
  const std::size_t pixel = view_n.image.index(static_cast<int>(std::floor(at->x() + 0.5)), static_cast<int>(std::floor(at->y() + 0.5)));
  const int index = data_n.at_pixel[pixel];
  if (index < 0 || (data_n.data[index].p_T - datum.p_T).squaredNorm() > threshold * threshold) return -1;
  return index;
}

}  // namespace

PointCloud IntegrateViews(std::span<const RangeView> views, const IntegrateOptions& options, std::stop_token stop) {
  std::vector<DataOfView> data(views.size());
  for (std::size_t m = 0; m < views.size(); ++m) {
    const std::size_t n_pixels = views[m].image.depth.size();
    if (views[m].classes.size() != n_pixels || views[m].normals_S.size() != n_pixels ||
        (!views[m].normal_residuals.empty() && views[m].normal_residuals.size() != n_pixels)) {
      throw std::invalid_argument("IntegrateViews: view " + std::to_string(m) + " has no normals or classes for every pixel");
    }
  }
  ParallelFor(static_cast<std::ptrdiff_t>(views.size()), options.threads, 1, [&](std::ptrdiff_t m) { data[m] = Gather(views[m]); });

  const int n_views = static_cast<int>(views.size());
  for (int m = 0; m < n_views; ++m) {
    ThrowIfStopped(stop);
    std::vector<Datum>& data_m = data[m].data;
    const int successors = n_views - m - 1;
    if (successors == 0) break;
    std::vector<int> same(data_m.size() * successors);
    ParallelFor(static_cast<std::ptrdiff_t>(data_m.size()), options.threads, 512, [&](std::ptrdiff_t i) {
      const double threshold = Threshold(views[m], data_m[i], options);
      for (int k = 0; k < successors; ++k) {
        const int n = m + 1 + k;
        same[i * successors + k] = data_m[i].kept ? RedundantIn(views[n], data[n], data_m[i], threshold) : -1;
      }
    });
    // Of each group of redundant data the best is kept. What has lost to a better one before stays out.
    for (std::size_t i = 0; i < data_m.size(); ++i) {
      if (!data_m[i].kept) continue;
      Datum* best = &data_m[i];
      for (int k = 0; k < successors; ++k) {
        const int index = same[i * successors + k];
        if (index < 0 || !data[m + 1 + k].data[index].kept) continue;
        Datum& other = data[m + 1 + k].data[index];
        Datum& worse = IsBetter(other, *best, options) ? *std::exchange(best, &other) : other;
        worse.kept = false;
      }
    }
  }

  PointCloud merged;
  for (int m = 0; m < n_views; ++m) {
    for (const Datum& datum : data[m].data) {
      if (!datum.kept) continue;
      merged.points.push_back(datum.p_T);
      merged.normals.push_back(views[m].X_TS.Rotate(views[m].normals_S[datum.pixel].cast<double>().normalized()));
      merged.normal_residuals.push_back(datum.residual);
      merged.views.push_back(m);
    }
  }
  return merged;
}

}  // namespace geond
