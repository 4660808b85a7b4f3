// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/point_cloud.h"
#include "core/range/range_view.h"

namespace geond {

// View integration (thesis App. B, Algorithm B.1).
struct IntegrateOptions {
  double distance = 0.0;          // m: data of two views closer than this in space are redundant; 0: one and a half
                                  // times the pitch of the pixels at the datum, and three times the noise
  double cosine_margin = 0.05;    // cosines of normal and line of sight closer than this count as equal
  double residual_margin = 0.2;   // relative: residuals of the normal fit closer than this count as equal
  int threads = 0;
};

// The data of all views in T, without the redundant ones: of those the one seen most squarely is kept, of equals the one
// with the smaller residual, of equals the one of the earlier view. With normals, residuals and views; in the order of
// views and pixels. Data without a normal take no part.
PointCloud IntegrateViews(std::span<const RangeView> views, const IntegrateOptions& options = {},
                          std::stop_token stop = {});

}  // namespace geond
