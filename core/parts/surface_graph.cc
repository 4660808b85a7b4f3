// SPDX-License-Identifier: Apache-2.0
// Walks over the pieces of a surface, and means over balls.
#include "core/parts/surface_graph.h"

#include <algorithm>

namespace geond {

const std::vector<int>& BallWalk::Collect(int seed, const Eigen::Vector3d& centre, double radius) {
  return Collect(seed, seed, centre, radius);
}

const std::vector<int>& BallWalk::Collect(int seed, int second_seed, const Eigen::Vector3d& centre, double radius) {
  if (++now_ == 0) {
    std::fill(stamp_.begin(), stamp_.end(), 0);
    now_ = 1;
  }
  found_.clear();
  for (int s : {seed, second_seed}) {
    if (stamp_[s] == now_) continue;
    stamp_[s] = now_;
    found_.push_back(s);
  }
  const double limit = radius * radius;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    for (int next : surface_.Neighbors(found_[i])) {
      if (stamp_[next] == now_) continue;
      stamp_[next] = now_;
      if ((surface_.centroids[next] - centre).squaredNorm() <= limit) found_.push_back(next);
    }
  }
  return found_;
}

std::vector<double> BallMean(const SurfaceGraph& surface, const std::vector<double>& values, double radius) {
  std::vector<double> means(values.size());
  BallWalk walk(surface);
  for (int t = 0; t < surface.n(); ++t) {
    double sum = 0.0, area = 0.0;
    for (int k : walk.Collect(t, surface.centroids[t], radius)) {
      sum += surface.areas[k] * values[k];
      area += surface.areas[k];
    }
    means[t] = area > 0.0 ? sum / area : values[t];
  }
  return means;
}

}  // namespace geond
