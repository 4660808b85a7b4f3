// SPDX-License-Identifier: Apache-2.0
#include "core/geon/one_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "core/geon/nearest.h"

namespace geond {
namespace {

constexpr std::size_t kLeastPoints = 40, kMostPoints = 400;
constexpr int kCandidates = 480;
// A normal faces the view if its cosine is above this; so many may not, for noise at the limb.
constexpr double kFacing = 0.03, kMostAway = 0.02;
// Outside the outline is further from every point than so many gaps between points, and than this many of the wide
// ones.
constexpr double kGaps = 1.6, kWideGaps = 1.2;

// A direction that all normals face, as squarely as the worst of them can.
std::optional<Eigen::Vector3d> ViewDirection(const std::vector<Eigen::Vector3d>& normals) {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& n : normals) direction += n;
  if (direction.norm() < 1e-3 * static_cast<double>(normals.size())) return std::nullopt;
  direction.normalize();
  std::vector<double> cosines(normals.size());
  const auto rank = static_cast<std::ptrdiff_t>(kMostAway * static_cast<double>(normals.size()));
  const auto worst = [&] {
    for (std::size_t i = 0; i < normals.size(); ++i) cosines[i] = normals[i].dot(direction);
    std::vector<double> sorted = cosines;
    std::nth_element(sorted.begin(), sorted.begin() + rank, sorted.end());
    return sorted[static_cast<std::size_t>(rank)];
  };
  Eigen::Vector3d best = direction;
  double best_worst = worst();
  for (int step = 0; step < 40; ++step) {
    const double limit = worst() + 0.05;
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < normals.size(); ++i)
      if (cosines[i] <= limit) pull += normals[i];
    if (pull.norm() < 1e-9) break;
    direction = (direction + 0.3 / (1.0 + 0.2 * step) * pull.normalized()).normalized();
    if (const double now = worst(); now > best_worst) {
      best_worst = now;
      best = direction;
    }
  }
  if (best_worst < kFacing) return std::nullopt;
  return best;
}

}  // namespace

OneView FindOneView(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& normals) {
  OneView view;
  if (points.size() < kLeastPoints) return view;
  const std::optional<Eigen::Vector3d> direction = ViewDirection(normals);
  if (!direction) return view;
  view.direction = *direction;

  // The points (some of them) as seen, with their depths.
  const Eigen::Vector3d a = direction->unitOrthogonal(), b = direction->cross(a);
  const std::size_t n = std::min(points.size(), kMostPoints);
  std::vector<Eigen::Vector2d> image;
  std::vector<double> depth;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& p = points[(2 * i + 1) * points.size() / (2 * n)];
    image.emplace_back(a.dot(p), b.dot(p));
    depth.push_back(direction->dot(p));
  }
  const auto [nearest, furthest] = std::minmax_element(depth.begin(), depth.end());
  const double range = std::max(*furthest - *nearest, 1e-9);

  // Distances to the third neighbour say how dense the points are: of even ones with a gap g it is 0.98 g.
  std::vector<double> third(n);
  for (std::size_t i = 0; i < n; ++i) {
    Nearest<4> near;   // itself first
    for (std::size_t j = 0; j < n; ++j) near.Add((image[j] - image[i]).squaredNorm(), static_cast<int>(j));
    third[i] = std::sqrt(near.square[3]) / 0.98;
  }
  const auto at_share = [&](double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(n - 1));
    std::nth_element(third.begin(), third.begin() + at, third.end());
    return third[static_cast<std::size_t>(at)];
  };
  const double reach = std::max(kGaps * at_share(0.5), kWideGaps * at_share(0.9));

  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < kCandidates; ++i) {
    const std::size_t from = static_cast<std::size_t>(i) * n / kCandidates;
    const double radius = reach * (i % 3 == 0 ? 1.2 : i % 3 == 1 ? 2.0 : 4.0);
    const Eigen::Vector2d at = image[from] + radius * Eigen::Vector2d(std::cos(golden * i), std::sin(golden * i));
    const bool outside = std::all_of(image.begin(), image.end(),
                                     [&](const Eigen::Vector2d& p) { return (p - at).squaredNorm() > reach * reach; });
    // Behind the points as well as among them: a view looks past all of it.
    const double z = *furthest - range * 1.6 * std::fmod(0.5 + i * 0.61803398874989485, 1.0);
    if (outside) view.empty.push_back(at.x() * a + at.y() * b + z * *direction);
  }
  return view;
}

}  // namespace geond
