// SPDX-License-Identifier: Apache-2.0
#pragma once

// Range data of one geon as a scanner would give it: points of the surface seen from some directions, noise along the ray,
// normals by plane fits to neighbours in the same view.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/Eigenvalues>

#include "core/geon/geon.h"
#include "core/geon/shape.h"
#include "tests/core/geon/random_geon.h"

namespace geond {

struct ViewOptions {
  int views = 4;               // evenly about the vertical, 20 degrees up; one: from anywhere
  int points = 400;
  double noise = 0.005;        // of the geon's diagonal, standard deviation along the ray
  int neighbours = 16;         // of a plane fit
  int dense = 2500;            // points a view that the neighbours are taken from
  double outliers = 0.0;       // share of points put anywhere in the box, half again as large, with any normal
};

inline double DiagonalOf(const Geon& geon) {   // of its axis-parallel box in G
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : SampleGeon(geon, 500).points) box.extend(Inverse(geon.X_TG) * p);
  return box.diagonal().norm();
}

// Whether the way from a surface point towards `direction` is free.
inline bool Seen(const Geon& geon, const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double diagonal) {
  if (!IsCurved(geon.type)) return true;
  const Pose X_GT = Inverse(geon.X_TG);
  for (double t = 0.03; t < 1.0; t += 0.025) {
    if (Gauge(geon, Undeform(geon, X_GT * (point + t * diagonal * direction))) < 0.99) return false;
  }
  return true;
}

// `surface` spread evenly and densely, `seen(point, direction to the sensor)` says whether nothing is in the way.
template <typename SeenFrom>
PointCloud ViewsOfSurface(const PointCloud& surface, double diagonal, const SeenFrom& seen_from, const ViewOptions& options,
                          Draw& draw) {
  std::vector<Eigen::Vector3d> directions;
  if (options.views == 1) {
    directions.push_back(draw.Normal3().normalized());
  } else {
    for (int v = 0; v < options.views; ++v) {
      const double azimuth = 2.0 * std::numbers::pi * v / options.views, up = 20.0 * std::numbers::pi / 180.0;
      directions.emplace_back(std::cos(up) * std::cos(azimuth), std::cos(up) * std::sin(azimuth), std::sin(up));
    }
  }
  PointCloud all;
  for (int v = 0; v < options.views; ++v) {
    const Eigen::Vector3d& to_sensor = directions[v];
    std::vector<Eigen::Vector3d> points, normals;
    double share = 1.0;   // so that about `dense` remain
    {
      double seen = 0.0;
      for (const Eigen::Vector3d& n : surface.normals) seen += std::max(0.0, n.dot(to_sensor));
      share = options.dense / std::max(seen, 1.0);
    }
    for (std::size_t i = 0; i < surface.size(); ++i) {
      const double cosine = surface.normals[i].dot(to_sensor);
      if (cosine < 0.17 || draw.Uniform(0, 1) > share * cosine || !seen_from(surface.points[i], to_sensor)) continue;
      points.push_back(surface.points[i] + options.noise * diagonal * draw.Normal() * to_sensor);
      normals.push_back(surface.normals[i]);
    }
    // This view's share of the points, each with the normal of its neighbourhood.
    const std::size_t count = std::min(points.size(), static_cast<std::size_t>(options.points / options.views));
    std::vector<int> order(points.size());
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = 0; i < count; ++i) {
      std::swap(order[i], order[i + static_cast<std::size_t>(draw.Uniform(0, 1) * static_cast<double>(order.size() - i))]);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d& p = points[order[i]];
      Eigen::Vector3d normal = normals[order[i]];
      if (options.noise > 0.0) {
        std::vector<std::pair<double, int>> near;
        for (std::size_t j = 0; j < points.size(); ++j) near.emplace_back((points[j] - p).squaredNorm(), static_cast<int>(j));
        std::nth_element(near.begin(), near.begin() + options.neighbours, near.end());
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        for (int k = 0; k <= options.neighbours; ++k) mean += points[near[k].second] / (options.neighbours + 1.0);
        Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
        for (int k = 0; k <= options.neighbours; ++k) {
          const Eigen::Vector3d d = points[near[k].second] - mean;
          scatter += d * d.transpose();
        }
        normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
        if (normal.dot(to_sensor) < 0.0) normal = -normal;
      }
      all.points.push_back(p);
      all.normals.push_back(normal);
      all.views.push_back(v);
    }
  }
  if (options.outliers > 0.0) {
    Eigen::AlignedBox3d box = BoundingBox(all.points);
    const Eigen::Vector3d middle = box.center(), half = 0.75 * box.sizes();
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (draw.Uniform(0, 1) >= options.outliers) continue;
      all.points[i] = middle + half.cwiseProduct(Eigen::Vector3d(draw.Uniform(-1, 1), draw.Uniform(-1, 1), draw.Uniform(-1, 1)));
      all.normals[i] = draw.Normal3().normalized();
    }
  }
  return all;
}

inline PointCloud ViewsOfGeon(const Geon& geon, const ViewOptions& options, Draw& draw) {
  const double diagonal = DiagonalOf(geon);
  const auto seen_from = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& direction) {
    return Seen(geon, point, direction, diagonal);
  };
  return ViewsOfSurface(SampleGeon(geon, 8 * options.dense), diagonal, seen_from, options, draw);
}

}  // namespace geond
