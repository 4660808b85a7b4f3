// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "core/geometry/triangle_mesh.h"
#include "core/surface/tessellate.h"

namespace geond {

// A closed two-manifold about the solid that a mesh from elsewhere means: open, doubled, self-crossing or wrongly turned
// triangles are told inside from outside by their generalised winding number on a grid (Jacobson et al. 2013). Holes are
// closed over (triangle_seen 0 there). Throws std::invalid_argument in one sentence if nothing is enclosed.
TriangleMesh CloseMesh(const TriangleMesh& mesh, const TessellateOptions& options = {}, std::stop_token stop = {});

}  // namespace geond
