// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/range/range_view.h"

namespace geond::calib {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// A view made ready for registration: its trusted points, and which pixels others may be compared with.
struct ViewPoints {
  const RangeView* view = nullptr;
  std::vector<Eigen::Vector3d> points_S;
  std::vector<Eigen::Vector3d> normals_S;
  std::vector<float> residuals;      // of the normals, m
  std::vector<std::uint8_t> target;  // a pixel: object with a normal, not at the rim of what is seen
  float crease = 0.0f;               // residual of a normal, m, above which its neighbourhood spans a crease
};
ViewPoints ReadyForRegistration(const RangeView& view);

// The middle value, or 0 of none; reorders them.
double Median(std::vector<float>& values);

struct PairOptions {
  double max_distance = 0.010;  // m, between a point and what it meets
  double min_cosine = 0.7;      // of the two normals
  double scale = 0.001;         // m, standard deviation of a distance along the normal
  int samples = 3000;           // at most so many points of the view
};

// What the overlap of two views says about small motions of both: points of view a, met by projection in the range image of
// view b, compared along the mean normal (symmetric point to plane). A motion is (rotation times `length`, translation)
// about `center_T`. Only the motion d of a less that of b counts, so that a common motion of both costs nothing, exactly:
// cost = sum w (r + j d)^2 / 2 = const + g d + d H d / 2 (over scale^2), j = (m x n, n) with m the middle of the two points.
struct PairTerm {
  int a = 0, b = 0;
  int points = 0;                   // that met
  double weight = 0.0;              // sum of robust weights (<= points)
  double squares = 0.0;             // sum of r^2 of all that met, m^2
  double loss = 0.0;                // sum of the robust loss of all that met, in scale^2 / 2
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  Matrix6d noise = Matrix6d::Zero();  // part of H that noise of the normals alone would make
  // Parts of H and noise by points at creases. A normal there is part of both faces and shows motions along either, which
  // the faces themselves do not show.
  Matrix6d H_creases = Matrix6d::Zero(), noise_creases = Matrix6d::Zero();
  std::vector<float> distances;     // |r| of all that met, m
};
PairTerm ComparePair(const std::vector<ViewPoints>& views, const std::vector<Pose>& X_TS, int a, int b,
                     const Eigen::Vector3d& center_T, double length, const PairOptions& options);

}  // namespace geond::calib
