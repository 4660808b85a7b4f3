// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace geond {

// A mesh as the parts see it: triangles in an order fixed by where they lie, not by their number, so that neither sums
// nor ties depend on the numbering of the input.
struct PartSurface {
  std::vector<int> source;                    // the triangle's index in the input mesh
  TriangleMesh mesh;                          // triangles reordered; vertices perhaps smoothed
  std::vector<Eigen::Vector3d> centroids;     // m
  std::vector<Eigen::Vector3d> area_vectors;  // m^2, outward
  std::vector<double> areas;                  // m^2
  std::vector<std::array<int, 3>> neighbors;  // direct connection graph (thesis Def. 4.3), -1 at a border
  double size = 0.0;                          // m: 2 sqrt(3) times the rms distance of the surface from its centroid,
                                              // the box diagonal of a ball, whatever the rotation
  double edge = 0.0;                          // m, mean edge length
  double area = 0.0;                          // m^2
  double noise = 0.0;                         // m, standard deviation of the vertices along the normal

  int n() const { return static_cast<int>(centroids.size()); }
  double EdgeLength(int triangle, int side) const;
  Eigen::Vector3d EdgeMiddle(int triangle, int side) const;
};

// `noise` < 0: estimated. The vertices are left where they are.
PartSurface MakePartSurface(const TriangleMesh& mesh, double noise = -1.0);

// Recomputes centroids, area vectors and areas after the vertices were moved.
void UpdateShape(PartSurface& surface);

// The standard deviation of vertex noise along the normal, m: from the median of how far each vertex lies from its
// ring, compared with its neighbours (a smooth surface cancels; creases are outliers).
double EstimateNoise(const TriangleMesh& mesh);

// `steps` pairs of Taubin's smoothing (0.5, -0.53), which keeps the volume (Taubin 1995). Border vertices stay.
void SmoothTaubin(PartSurface& surface, int steps);

// Visits the triangles that hang together with `seed` inside the ball (centre, radius); `seed` always. A cap on the
// number keeps fine meshes affordable; 0 is none.
class BallWalk {
 public:
  explicit BallWalk(const PartSurface& surface) : surface_(surface), stamp_(surface.n(), 0) {}

  // The triangles, nearest in steps first; valid until the next call.
  const std::vector<int>& Collect(int seed, const Eigen::Vector3d& centre, double radius);
  const std::vector<int>& Collect(int seed, int second_seed, const Eigen::Vector3d& centre, double radius);

 private:
  const PartSurface& surface_;
  std::vector<std::uint32_t> stamp_;
  std::uint32_t now_ = 0;
  std::vector<int> found_;
};

// The mean by area of a value of triangles over balls of `radius`.
std::vector<double> BallMean(const PartSurface& surface, const std::vector<double>& values, double radius);

}  // namespace geond
