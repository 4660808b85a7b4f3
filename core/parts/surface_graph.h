// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace geond {

// Pieces of a surface and what they share: triangles and their edges (the direct connection graph, thesis Def. 4.3), or
// patches of triangles and the borders between them. Arc k of piece p: first[p] <= k < first[p + 1]; each border has an
// arc on either side.
struct SurfaceGraph {
  std::vector<Eigen::Vector3d> centroids;     // m
  std::vector<Eigen::Vector3d> area_vectors;  // m^2, outward
  std::vector<double> areas;                  // m^2
  std::vector<int> first;                     // n + 1
  std::vector<int> to;                        // an arc: the piece beyond
  std::vector<double> lengths;                // an arc: of the border, m
  std::vector<Eigen::Vector3d> middles;       // an arc: of the border, m
  std::vector<bool> at_border;                // a piece: it has an edge without a neighbour
  double size = 0.0;  // m: 2 sqrt(3) times the rms distance of the surface from its centroid, the box diagonal of a
                      // ball, whatever the rotation
  double edge = 0.0;  // m, between the middles of neighbouring pieces: the mean edge length of triangles
  double area = 0.0;  // m^2

  int n() const { return static_cast<int>(centroids.size()); }
  std::span<const int> Neighbors(int piece) const {
    return {to.data() + first[piece], static_cast<std::size_t>(first[piece + 1] - first[piece])};
  }
};

// Visits the pieces that hang together with `seed` inside the ball (centre, radius); `seed` always.
class BallWalk {
 public:
  explicit BallWalk(const SurfaceGraph& surface) : surface_(surface), stamp_(surface.n(), 0) {}

  // The pieces, nearest in steps first; valid until the next call.
  const std::vector<int>& Collect(int seed, const Eigen::Vector3d& centre, double radius);
  const std::vector<int>& Collect(int seed, int second_seed, const Eigen::Vector3d& centre, double radius);

 private:
  const SurfaceGraph& surface_;
  std::vector<std::uint32_t> stamp_;
  std::uint32_t now_ = 0;
  std::vector<int> found_;
};

// The mean by area of a value of pieces over balls of `radius`.
std::vector<double> BallMean(const SurfaceGraph& surface, const std::vector<double>& values, double radius);

}  // namespace geond
