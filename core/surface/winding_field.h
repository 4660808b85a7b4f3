// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "core/surface/signed_grid.h"
#include "core/surface/winding_number.h"

namespace geond {

// What a field near a surface is made of: the distance (m) from p to it, or `limit` if that is further, and the value of
// the field (m, negative inside) there, none beyond its reach. `winding` works the winding number at p out when asked.
struct FieldSource {
  std::function<double(const Eigen::Vector3d& p, double limit)> distance;
  std::function<std::optional<double>(const Eigen::Vector3d& p, const std::function<double()>& winding)> value;
  double reach = 0.0;  // m
};

// The grid filled with source.value near the surface, else with (1 - 2 winding number) reach: at holes a smooth lid. Every
// node near the surface or a lid is worked out, others take the number of their surroundings. Positive on the border of the
// grid. Throws Cancelled.
SignedGrid WindingField(SignedGrid grid, const WindingNumber& winding, const FieldSource& source, int threads,
                        const std::stop_token& stop);

}  // namespace geond
