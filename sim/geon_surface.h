// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"
#include "core/geon/geon.h"

namespace geond::sim {

// The exact surface of a geon as a ray meets it. This is the simulator's own form of the thesis' equations (5.1) to
// (5.9), with the corrections for apex, wide bends and small curvature, kept apart from the one that fits, so that
// neither can hide an error of the other.
class GeonSurface {
 public:
  // Throws std::invalid_argument if a size is not positive, a taper is outside [0, 0.98], a bend folds the geon over
  // (kappa ax >= 1) or closes it to a ring (kappa az > pi).
  explicit GeonSurface(const Geon& geon);

  // The inside-outside value in T: 1 on the surface, less inside, growing like a distance in half sizes outside
  // (f^(1/p) of the undeformed point), and its gradient (1/m, outward).
  struct Value {
    double value;
    Eigen::Vector3d gradient;
  };
  Value At(const Eigen::Vector3d& p_T) const;

  // A closed mesh in T that lies wholly outside the surface and close to it: where a ray enters the shell, its first
  // meeting with the surface is looked for.
  const TriangleMesh& shell() const { return shell_; }

  // First t >= t_enter with origin + t direction on the surface, for a ray that is outside at t_enter and going in;
  // none if the ray passes by. Newton's rule, safeguarded by halving.
  std::optional<double> Meet(const Eigen::Vector3d& origin_T, const Eigen::Vector3d& direction_T, double t_enter) const;

  // A point of the surface (T) along a direction in the undeformed half-size space; used for extents.
  Eigen::Vector3d PointAlong(const Eigen::Vector3d& direction) const { return Deform(direction, 1.0); }
  double lowest_z() const { return lowest_z_; }  // of the surface, in T, m
  double highest_z() const { return highest_z_; }

 private:
  Eigen::Vector3d Deform(const Eigen::Vector3d& direction, double level) const;
  void BuildShell();

  Geon geon_;
  Pose X_GT_;
  Eigen::Matrix3d R_GT_;
  double reach_ = 0.0;  // m, no two points of the shell are further apart
  TriangleMesh shell_;
  double lowest_z_ = 0.0, highest_z_ = 0.0;
};

}  // namespace geond::sim
