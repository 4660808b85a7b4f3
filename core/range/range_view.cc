// SPDX-License-Identifier: Apache-2.0
#include "core/range/range_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/parallel.h"

namespace geond {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Along a plane the quantity q is linear in column and row: 1/z seen in perspective, z seen by parallel rays. The noise
// of a rangefinder lies along the ray, so that least squares in q (pixels exact) is the better of the plane fits: it
// has no bias towards the line of sight, as the fit of least distances has where the noise nears the size of the
// window.
struct LinearFit {
  double q = 0, q_u = 0, q_v = 0;  // value at the centre pixel, slopes a pixel
};

// Sums over the neighbours taken, in pixels from the centre.
struct Moments {
  double n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0, q = 0, qu = 0, qv = 0;

  void Add(double du, double dv, double value) {
    n += 1, u += du, v += dv, uu += du * du, uv += du * dv, vv += dv * dv;
    q += value, qu += value * du, qv += value * dv;
  }

  // False if the pixels lie (nearly) in a line, so that they carry no plane.
  bool Solve(LinearFit& fit) const {
    const double suu = uu - u * u / n, suv = uv - u * v / n, svv = vv - v * v / n;
    const double det = suu * svv - suv * suv, trace = suu + svv;
    if (!(det > 0.02 * trace * trace)) return false;
    const double squ = qu - q * u / n, sqv = qv - q * v / n;
    fit.q_u = (squ * svv - sqv * suv) / det;
    fit.q_v = (sqv * suu - squ * suv) / det;
    fit.q = (q - fit.q_u * u - fit.q_v * v) / n;
    return true;
  }
};

struct PixelNormal {
  bool trusted = false;
  Eigen::Vector3f normal = Eigen::Vector3f::Constant(kNan);
  float residual = kNan;
};

// The work on one pixel, with what is the same for all of them.
class PlaneFitter {
 public:
  PlaneFitter(const RangeView& view, const NormalOptions& options)
      : view_(view),
        options_(options),
        half_(options.window / 2),
        perspective_(view.sensor.projection == SensorModel::Projection::kPerspective),
        tan_incidence_(std::tan(options.max_incidence)),
        cos_incidence_(std::cos(options.max_incidence)) {}

  PixelNormal Fit(int column, int row) const {
    const double z = view_.image.at(column, row);
    PixelNormal result;
    if (!std::isfinite(z) || (perspective_ && z <= 0.0)) return result;
    const double pitch =
        (perspective_ ? z : 1.0) / std::min(std::abs(view_.sensor.focal_u), std::abs(view_.sensor.focal_v));

    Moments moments;
    ForEachNeighbor(column, row, z, pitch, [&](int du, int dv, double depth) {
      // Relative to the centre, which keeps the digits.
      moments.Add(du, dv, perspective_ ? (z - depth) / (z * depth) : depth - z);
    });
    LinearFit fit;
    if (moments.n - 1 < options_.min_neighbors || !moments.Solve(fit)) return result;

    const Eigen::Vector3d normal = NormalOf(fit, column, row, z);
    const Eigen::Vector3d ray = RayDirection(view_.sensor, column, row);
    const double facing = -normal.dot(ray);
    if (!(facing >= cos_incidence_)) return result;

    const Eigen::Vector3d at = Unproject(view_.sensor, column, row, z);
    double sum = 0.0, sum_squared = 0.0;
    ForEachNeighbor(column, row, z, pitch, [&](int du, int dv, double depth) {
      const double distance = normal.dot(Unproject(view_.sensor, column + du, row + dv, depth) - at);
      sum += distance;
      sum_squared += distance * distance;
    });
    const double mean = sum / moments.n;
    result.trusted = true;
    result.normal = normal.cast<float>();
    result.residual = static_cast<float>(std::sqrt(std::max(0.0, sum_squared / moments.n - mean * mean)));
    return result;
  }

 private:
  // The object pixels of the window, the centre included, on the centre's side of every depth jump.
  template <typename OnNeighbor>
  void ForEachNeighbor(int column, int row, double z, double pitch, const OnNeighbor& on_neighbor) const {
    const RangeImage& image = view_.image;
    const double noise = 6.0 * view_.sensor.depth_noise;
    for (int dv = -half_; dv <= half_; ++dv) {
      for (int du = -half_; du <= half_; ++du) {
        if (!image.contains(column + du, row + dv)) continue;
        const std::size_t pixel = image.index(column + du, row + dv);
        const double depth = image.depth[pixel];
        if (view_.classes[pixel] != PixelClass::kObject || !std::isfinite(depth) || (perspective_ && depth <= 0.0))
          continue;
        const double step = std::max(std::abs(du), std::abs(dv));
        const double jump =
            options_.max_depth_jump > 0.0 ? options_.max_depth_jump : noise + tan_incidence_ * pitch * step;
        if (std::abs(depth - z) <= jump) on_neighbor(du, dv, depth);
      }
    }
  }

  // Unit normal towards the sensor of the plane with q = q0 + q_u (u - column) + q_v (v - row). With p = z r(u, v), r =
  // (x, y, 1), the plane n.p = d reads n.r = d / z, linear in u and v: n_x = f_u q_u, n_y = f_v q_v up to the factor d.
  Eigen::Vector3d NormalOf(const LinearFit& fit, int column, int row, double z) const {
    const SensorModel& sensor = view_.sensor;
    Eigen::Vector3d n(sensor.focal_u * fit.q_u, sensor.focal_v * fit.q_v, -1.0);
    if (perspective_) {
      const Eigen::Vector3d r = Unproject(sensor, column, row, 1.0);
      n.z() = (1.0 / z + fit.q) - n.x() * r.x() - n.y() * r.y();
      // n.r = 1/z > 0 at the centre: n points away from the sensor.
      n = -n;
    }
    return n.normalized();
  }

  const RangeView& view_;
  const NormalOptions& options_;
  const int half_;
  const bool perspective_;
  const double tan_incidence_, cos_incidence_;
};

}  // namespace

PointCloud ViewCloud(const RangeView& view) {
  PointCloud cloud;
  if (view.normals_S.empty()) return cloud;
  for (int row = 0; row < view.image.rows; ++row) {
    for (int column = 0; column < view.image.columns; ++column) {
      const std::size_t pixel = view.image.index(column, row);
      if (!view.IsObject(pixel) || !view.normals_S[pixel].allFinite()) continue;
      cloud.points.push_back(Unproject(view.sensor, column, row, view.image.depth[pixel]));
      cloud.normals.push_back(view.normals_S[pixel].cast<double>().normalized());
      if (!view.normal_residuals.empty()) cloud.normal_residuals.push_back(view.normal_residuals[pixel]);
    }
  }
  return cloud;
}

RangeView EstimateNormals(RangeView view, const NormalOptions& options, int threads) {
  const std::size_t n = static_cast<std::size_t>(view.image.columns) * view.image.rows;
  if (view.image.columns < 0 || view.image.rows < 0 || view.image.depth.size() != n || view.classes.size() != n) {
    throw std::invalid_argument("EstimateNormals: depth and classes must have one entry a pixel");
  }
  if (options.window < 3 || options.window % 2 == 0 || options.min_neighbors < 2 || !(options.max_incidence > 0.0) ||
      !(options.max_incidence < 1.5707) || !(options.max_depth_jump >= 0.0)) {
    throw std::invalid_argument(
        "EstimateNormals: window odd and >= 3, min_neighbors >= 2, 0 < max_incidence < pi/2, "
        "max_depth_jump >= 0 are wanted");
  }
  std::vector<PixelClass> classes = view.classes;
  std::vector<Eigen::Vector3f> normals(n, Eigen::Vector3f::Constant(kNan));
  std::vector<float> residuals(n, kNan);
  const PlaneFitter fitter(view, options);
  ParallelFor(view.image.rows, threads, 8, [&](std::ptrdiff_t row) {
    for (int column = 0; column < view.image.columns; ++column) {
      const std::size_t pixel = view.image.index(column, static_cast<int>(row));
      if (view.classes[pixel] != PixelClass::kObject) continue;
      const PixelNormal fit = fitter.Fit(column, static_cast<int>(row));
      if (!fit.trusted) classes[pixel] = PixelClass::kRejected;
      normals[pixel] = fit.normal;
      residuals[pixel] = fit.residual;
    }
  });
  view.classes = std::move(classes);
  view.normals_S = std::move(normals);
  view.normal_residuals = std::move(residuals);
  return view;
}

}  // namespace geond
