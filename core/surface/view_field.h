// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/range/range_view.h"
#include "core/surface/signed_grid.h"

namespace geond {

// What the views together say of a node of the grid.
enum class NodeState : std::uint8_t {
  kUnknown = 0,  // no view looks there, or all see something before it
  kNear = 1,     // within the truncation of a measured surface
  kFree = 2,     // a view looks through it
};

// Truncated signed distance (m, negative inside) of the views, with what is known of each node.
struct ViewField {
  SignedGrid distance;
  std::vector<NodeState> state;
  double truncation = 0.0;
};

// Fuses views in T after Curless and Levoy (1996), with the distance along the estimated normal instead of the ray, and
// free space carved by all that was seen beyond it: object, table and background. Nodes of `grid` not reached stay unknown
// with value -truncation. Throws Cancelled.
ViewField FuseViews(std::span<const RangeView> views, SignedGrid grid, double truncation, int threads,
                    const std::stop_token& stop);

// Gives unknown nodes values that continue those around them smoothly (harmonic). If closed by the table, nodes below z = 0
// take no part; elsewhere the border of the grid counts as free.
void DiffuseUnknown(ViewField& field, bool closed_by_table, int threads, const std::stop_token& stop);

}  // namespace geond
