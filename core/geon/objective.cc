// SPDX-License-Identifier: Apache-2.0
#include "core/geon/objective.h"

#include <cmath>
#include <stdexcept>

#include "core/geon/shape.h"

namespace geond {

std::vector<PointError> PointErrors(const Geon& geon, const PointCloud& part) {
  CheckGeon(geon);
  if (!part.has_normals()) throw std::invalid_argument("the objective of a geon needs points with normals");
  const Pose X_GT = Inverse(geon.X_TG);
  std::vector<PointError> errors;
  errors.reserve(part.size());
  for (const Eigen::Vector3d& p_T : part.points) {
    const Eigen::Vector3d p = X_GT * p_T, d = Undeform(geon, p);
    const double s = Gauge(geon, d);
    PointError error;
    if (s == 0.0) {   // at the centre every direction is as good
      error.e = error.distance = -geon.size.minCoeff();
    } else {
      const Eigen::Vector3d n = SurfaceNormal(geon, d);
      error.e = d.norm() * (1.0 - 1.0 / s);
      error.model_normal = geon.X_TG.Rotate(n);
      error.distance = n.dot(p - Deform(geon, d / s));
    }
    errors.push_back(error);
  }
  return errors;
}

Objective EvaluateObjective(const Geon& geon, const PointCloud& part, double lambda) {
  Objective sum;
  const std::vector<PointError> errors = PointErrors(geon, part);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    sum.t1 += std::abs(errors[i].e);
    sum.t2 += (part.normals[i] - errors[i].model_normal).squaredNorm();
    sum.distance += std::abs(errors[i].distance);
  }
  const double n = static_cast<double>(errors.size());
  sum.t1 /= n;
  sum.t2 /= n;
  sum.distance /= n;
  sum.value = sum.t1 + lambda * geon.size.mean() * sum.t2;
  return sum;
}

}  // namespace geond
