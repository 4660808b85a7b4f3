// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/parts/surface_graph.h"

namespace geond {

// Undoes cuts that nobody saw: where a mesh was closed over, its shape is a guess, and a crease there says nothing.
// Parts are joined over a boundary that runs for its most part through such places (further than two triangles from
// seen ones), and a part that was hardly seen at all joins the neighbour with which it shares most; both in proportion
// to what was seen of the whole, for one view shows no more than half of any cut. `seen`: one a triangle of the surface.
void JoinOverUnseen(const SurfaceGraph& surface, const std::vector<std::uint8_t>& seen, std::vector<int>& labels);

}  // namespace geond
