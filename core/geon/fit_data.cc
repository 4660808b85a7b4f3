// SPDX-License-Identifier: Apache-2.0
#include "core/geon/fit_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Eigenvalues>

#include "core/geon/one_view.h"
#include "core/geon/outliers.h"

namespace geond {
namespace {

constexpr int kLeastPoints = 12;
// Coordinates are rounded to this share of the unit: two copies of the same data in different frames then become the same
// numbers, and the fits after them the same steps.
constexpr double kGrid = 0x1p-31;
// Empty places are taken from a box larger by this share of its sides on each side, and so many at most.
constexpr double kReach = 0.6;
constexpr int kMostEmpty = 192;
constexpr double kEmptyWeight = 3.0;   // of all of them over that of all points

struct Sample {
  Eigen::Vector3d point, normal;
  std::uint64_t code = 0;   // along the curve
};

std::uint64_t SpreadBits(std::uint64_t v) {   // 21 bits to every third place
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  return (v | v << 2) & 0x1249249249249249;
}

// Axes along the principal ones, least spread first; signs by the third moments of points and normals, so that the frame
// turns with the data. Data with a symmetry have no such frame, and none that matters.
Eigen::Matrix3d PrincipalFrame(const std::vector<Sample>& samples) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples) scatter += s.point * s.point.transpose();
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors();
  for (int k = 0; k < 2; ++k) {
    double skew = 0.0;
    for (const Sample& s : samples) {
      const double x = axes.col(k).dot(s.point);
      skew += x * x * x;
    }
    if (skew < 0.0) axes.col(k) = -axes.col(k);
  }
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

double Rounded(double x, double grid) { return std::nearbyint(x / grid) * grid; }

// `count` of them, or all if there are fewer, evenly along the curve.
std::vector<Sample> Every(const std::vector<Sample>& samples, int count) {
  const auto n = static_cast<std::int64_t>(samples.size());
  const std::int64_t kept = std::min<std::int64_t>(count, n);
  std::vector<Sample> some;
  for (std::int64_t i = 0; i < kept; ++i) some.push_back(samples[static_cast<std::size_t>((2 * i + 1) * n / (2 * kept))]);
  return some;
}

// Evenly `count` of them in their order, or all if there are fewer.
std::vector<Eigen::Vector3d> Spread(const std::vector<Eigen::Vector3d>& places, int count) {
  const auto n = static_cast<std::int64_t>(places.size());
  if (n <= count) return places;
  std::vector<Eigen::Vector3d> some;
  for (std::int64_t i = 0; i < count; ++i) some.push_back(places[static_cast<std::size_t>((2 * i + 1) * n / (2 * count))]);
  return some;
}

LanePoints LanesOf(const std::vector<Sample>& samples) {
  LanePoints points(static_cast<int>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) points.Set(static_cast<int>(i), samples[i].point, samples[i].normal);
  return points;
}

// Without the outliers; how many there were to `count`.
std::vector<Sample> WithoutOutliers(const std::vector<Sample>& samples, int& count) {
  std::vector<Eigen::Vector3d> points, normals;
  for (const Sample& s : samples) {
    points.push_back(s.point);
    normals.push_back(s.normal);
  }
  const std::vector<bool> outlier = FindOutliers(points, normals);
  std::vector<Sample> left;
  for (std::size_t i = 0; i < samples.size(); ++i) if (!outlier[i]) left.push_back(samples[i]);
  count = static_cast<int>(samples.size() - left.size());
  return left.size() >= kLeastPoints ? left : samples;
}

}  // namespace

FitData PrepareFitData(const PointCloud& part, const Surroundings& around, bool outline, int max_points,
                       int search_points) {
  if (!part.has_normals()) throw std::invalid_argument("fitting geons needs points with outward normals");
  FitData data;
  std::vector<Sample> samples;
  samples.reserve(part.size());
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double length = part.normals[i].norm();
    if (part.points[i].allFinite() && std::isfinite(length) && length > 1e-6) {
      samples.push_back({part.points[i], part.normals[i] / length});
    }
  }
  const auto refuse = [&](std::size_t left) {
    throw std::invalid_argument("fitting geons needs at least " + std::to_string(kLeastPoints) +
                                " different finite points with normals; of " + std::to_string(part.size()) + " there are " +
                                std::to_string(left));
  };
  if (samples.size() < kLeastPoints) refuse(samples.size());

  // Sums in an order that does not depend on the frame would cost a sort; their rounding is far below the grid.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Sample& s : samples) mean += s.point - samples[0].point;
  mean = samples[0].point + mean / static_cast<double>(samples.size());
  for (Sample& s : samples) s.point -= mean;
  const Eigen::Matrix3d axes = PrincipalFrame(samples);
  Eigen::AlignedBox3d box;
  for (Sample& s : samples) {
    s.point = axes.transpose() * s.point;
    s.normal = axes.transpose() * s.normal;
    box.extend(s.point);
  }
  data.unit = box.diagonal().norm();
  if (!(data.unit > 0.0)) throw std::invalid_argument("all points to fit geons to lie in one place");
  data.X_TN = Pose(axes, mean);
  for (Sample& s : samples) {
    s.point = (s.point / data.unit).unaryExpr([](double x) { return Rounded(x, kGrid); });
    s.normal = s.normal.unaryExpr([](double x) { return Rounded(x, kGrid); });
    const Eigen::Vector3d cell = (s.point.array() + 1.0) * static_cast<double>(1 << 20);
    s.code = SpreadBits(static_cast<std::uint64_t>(cell.x())) | SpreadBits(static_cast<std::uint64_t>(cell.y())) << 1 |
             SpreadBits(static_cast<std::uint64_t>(cell.z())) << 2;
  }
  const auto key = [](const Sample& s) {
    return std::tie(s.code, s.point.x(), s.point.y(), s.point.z(), s.normal.x(), s.normal.y(), s.normal.z());
  };
  std::sort(samples.begin(), samples.end(), [&](const Sample& a, const Sample& b) { return key(a) < key(b); });
  samples.erase(std::unique(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) { return a.point == b.point; }),
                samples.end());
  if (samples.size() < kLeastPoints) refuse(samples.size());
  data.used = static_cast<int>(samples.size());
  data.dropped = static_cast<int>(part.size()) - data.used;
  samples = WithoutOutliers(Every(samples, std::max(max_points, kLeastPoints)), data.outliers);
  for (const Sample& s : samples) data.box.extend(s.point);
  data.all = LanesOf(samples);
  data.few = LanesOf(Every(samples, std::max(search_points, kLeastPoints)));

  // Empty places count as a whole, so that a few that are covered weigh what as many points would. Far ones say nothing.
  const Pose X_NT = Inverse(data.X_TN);
  const auto own = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d((X_NT * p / data.unit).unaryExpr([](double x) { return Rounded(x, kGrid); }));
  };
  Eigen::AlignedBox3d near(data.box.min() - kReach * data.box.sizes(), data.box.max() + kReach * data.box.sizes());
  for (const Eigen::Vector3d& p : around.empty) {
    if (const Eigen::Vector3d q = own(p); near.contains(q)) data.around.empty.push_back(q);
  }
  std::vector<Eigen::Vector3d> points, normals;
  for (const Sample& s : samples) {
    points.push_back(s.point);
    normals.push_back(s.normal);
  }
  OneView view = FindOneView(points, normals);
  data.view = view.direction;
  // Where nothing else is known, the outline of the points themselves.
  if (outline && around.empty.empty() && around.cuts.empty()) data.around.empty = std::move(view.empty);
  data.around.empty = Spread(data.around.empty, kMostEmpty);
  data.all.AddEmpty(data.around.empty, kEmptyWeight * data.all.size);
  data.few.AddEmpty(Spread(data.around.empty, kMostEmpty / 4), kEmptyWeight * data.few.size);
  for (const Eigen::Vector3d& p : around.cuts) data.around.cuts.push_back(own(p));
  return data;
}

FitData PrepareFitData(const PointCloud& part, int max_points, int search_points) {
  return PrepareFitData(part, {}, false, max_points, search_points);
}

}  // namespace geond
