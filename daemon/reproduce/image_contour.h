// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

namespace geond::reproduce {

// Contours as an image gives them, and what the thesis does with them (6.3.1).

// The outline of a polygon drawn into an image: its border pixels in order, each a step to one of eight neighbours, in
// pixels. `per_unit` is the number of pixels a unit of the polygon.
std::vector<Eigen::Vector2d> PixelContour(const std::vector<Eigen::Vector2d>& polygon, double per_unit);

// The contour without its highest frequencies: all those above the last whose Fourier component has `percent` of the magnitude
// of the largest one (the mean apart). 0 leaves it as it is.
std::vector<Eigen::Vector2d> LowPass(const std::vector<Eigen::Vector2d>& contour, double percent);

// Incremental curvature with increment 1: the turn of the tangent at each vertex over the mean length of its two steps,
// rad a unit; positive where a counter-clockwise contour is convex.
std::vector<double> IncrementalCurvature(const std::vector<Eigen::Vector2d>& contour);

// Length along the contour up to each vertex, as a share of the whole, %.
std::vector<double> ArcShare(const std::vector<Eigen::Vector2d>& contour);

// Places of local maxima: greatest within `reach` places on either side, round the contour.
std::vector<int> LocalMaxima(const std::vector<double>& values, int reach);

}  // namespace geond::reproduce
