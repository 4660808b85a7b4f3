// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <stop_token>

#include "core/surface/signed_grid.h"
#include "core/surface/winding_number.h"

namespace geond {

// Distance (m) from p to the surface, or `limit` if that is further.
using SurfaceDistance = std::function<double(const Eigen::Vector3d& p, double limit)>;

// The grid filled with (1 - 2 winding number) times the distance to the surface, no more than `reach`: near the surface
// the signed distance, at holes a smooth lid. Every node near the surface or a lid is worked out, others are interpolated.
SignedGrid WindingField(SignedGrid grid, const WindingNumber& winding, const SurfaceDistance& distance, double reach,
                        int threads, const std::stop_token& stop);

}  // namespace geond
