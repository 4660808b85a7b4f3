// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/parts/surface_graph.h"

namespace geond {

// A mesh as the parts see it: triangles in an order fixed by where they lie, not by their number, so that neither sums
// nor ties depend on the numbering of the input.
struct PartSurface {
  std::vector<int> source;                   // the triangle's index in the input mesh
  TriangleMesh mesh;                         // triangles reordered; vertices perhaps smoothed
  SurfaceGraph graph;                        // of the triangles
  std::vector<std::array<int, 2>> arc_ends;  // an arc of the graph: the vertices of its edge
  double noise = 0.0;                        // m, standard deviation of the vertices along the normal

  int n() const { return graph.n(); }
};

// `noise` < 0: estimated. The vertices are left where they are.
PartSurface MakePartSurface(const TriangleMesh& mesh, double noise = -1.0);

// The standard deviation of vertex noise along the normal, m: from the median of how far each vertex lies from its
// ring, compared with its neighbours (a smooth surface cancels; creases are outliers).
double EstimateNoise(const TriangleMesh& mesh);

// `steps` pairs of Taubin's smoothing (0.5, -0.53), which keeps the volume (Taubin 1995). Border vertices stay.
void SmoothTaubin(PartSurface& surface, int steps);

}  // namespace geond
