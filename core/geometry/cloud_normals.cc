// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/cloud_normals.h"

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include <Eigen/Eigenvalues>

#include "core/base/parallel.h"
#include "core/geometry/point_index.h"

namespace geond {
namespace {

// Directions spread over the upper half sphere (Fibonacci).
std::vector<Eigen::Vector3d> HalfSphere(int count) {
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, radius = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  return directions;
}

// The share of directions (the 26 of a cube's faces, edges and corners) in which points lie as seen from their middle.
double CoverageOfDirections(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& middle) {
  std::set<std::array<int, 3>> seen;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = (p - middle) / std::max((p - middle).cwiseAbs().maxCoeff(), 1e-300);
    seen.insert({static_cast<int>(std::lround(d.x())), static_cast<int>(std::lround(d.y())), static_cast<int>(std::lround(d.z()))});
  }
  return static_cast<double>(seen.size()) / 26.0;
}

}  // namespace

PointCloud EstimateCloudNormals(PointCloud cloud, int neighbors, int threads) {
  if (static_cast<int>(cloud.size()) < neighbors || neighbors < 3) {
    throw std::invalid_argument("EstimateCloudNormals: " + std::to_string(cloud.size()) + " points are too few");
  }
  const PointIndex index(cloud.points);
  cloud.normals.resize(cloud.size());
  cloud.normal_residuals.resize(cloud.size());
  ParallelFor(static_cast<std::ptrdiff_t>(cloud.size()), threads, 256, [&](std::ptrdiff_t i) {
    const PointIndex::Neighbors near = index.Nearest(cloud.points[i], neighbors);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& [j, squared_distance] : near) mean += cloud.points[j];
    mean /= neighbors;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const auto& [j, squared_distance] : near) scatter += (cloud.points[j] - mean) * (cloud.points[j] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
    cloud.normals[i] = eigen.eigenvectors().col(0).normalized();
    cloud.normal_residuals[i] = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]) / neighbors);
  });
  return cloud;
}

PointCloud OrientTowards(PointCloud cloud, const Eigen::Vector3d& viewpoint) {
  if (!cloud.has_normals()) throw std::invalid_argument("OrientTowards: the cloud has no normals");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.normals[i].dot(viewpoint - cloud.points[i]) < 0.0) cloud.normals[i] = -cloud.normals[i];
  }
  return cloud;
}

Eigen::Vector3d GuessViewingSide(const PointCloud& cloud) {
  if (!cloud.has_normals()) throw std::invalid_argument("GuessViewingSide: the cloud has no normals");
  // Pairs of neighbours of an even thinning.
  constexpr std::size_t kSamples = 2000;
  constexpr int kNeighbors = 6;
  const std::size_t step = std::max<std::size_t>(1, cloud.size() / kSamples);
  std::vector<int> kept;
  for (std::size_t i = 0; i < cloud.size(); i += step) kept.push_back(static_cast<int>(i));
  const PointCloud thin = Select(cloud, kept);
  const PointIndex index(thin.points);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < thin.size(); ++i) {
    for (const auto& [j, squared_distance] : index.Nearest(thin.points[i], kNeighbors)) pairs.emplace_back(static_cast<int>(i), j);
  }

  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double best_agreement = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& direction : HalfSphere(200)) {
    double agreement = 0.0;
    for (const auto& [i, j] : pairs) {
      const double sign = thin.normals[i].dot(direction) * thin.normals[j].dot(direction) < 0.0 ? -1.0 : 1.0;
      agreement += sign * thin.normals[i].dot(thin.normals[j]);
    }
    if (agreement > best_agreement) best_agreement = agreement, best = direction;
  }

  // Many directions agree about as well: the mean of the normals, turned their way, is in the middle of them.
  for (int round = 0; round < 3; ++round) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& n : thin.normals) sum += n.dot(best) < 0.0 ? Eigen::Vector3d(-n) : n;
    best = sum.normalized();
  }

  // A body bulges towards the one who looks at it: normals point away from the middle.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : thin.points) mean += p;
  mean /= static_cast<double>(thin.size());
  double bulge = 0.0;
  for (std::size_t i = 0; i < thin.size(); ++i) {
    const double sign = thin.normals[i].dot(best) < 0.0 ? -1.0 : 1.0;
    bulge += sign * thin.normals[i].dot(thin.points[i] - mean);
  }
  return bulge < 0.0 ? Eigen::Vector3d(-best) : best;
}

PointCloud WithOutwardNormals(const PointCloud& cloud, std::vector<std::string>* notes) {
  if (cloud.has_normals()) return cloud;
  const auto note = [&](const char* text) {
    if (notes) notes->push_back(text);
  };
  PointCloud oriented = EstimateCloudNormals(cloud);
  const Eigen::AlignedBox3d box = BoundingBox(cloud.points);
  const double diagonal = box.diagonal().norm();
  if (CoverageOfDirections(cloud.points, box.center()) > 0.9) {
    note("normals estimated, turned away from the middle");
    for (std::size_t i = 0; i < oriented.size(); ++i) {
      if (oriented.normals[i].dot(oriented.points[i] - box.center()) < 0.0) oriented.normals[i] = -oriented.normals[i];
    }
    return oriented;
  }
  if (box.exteriorDistance(Eigen::Vector3d::Zero()) > 0.5 * diagonal) {
    note("normals estimated, turned to a sensor at the origin");
    return OrientTowards(std::move(oriented), Eigen::Vector3d::Zero());
  }
  note("normals estimated, turned to the side that makes a body of it");
  return OrientTowards(oriented, box.center() + 1e3 * diagonal * GuessViewingSide(oriented));
}

}  // namespace geond
