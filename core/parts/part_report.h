// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/parts/part_surface.h"
#include "core/parts/patches.h"
#include "core/parts/segment.h"

namespace geond {

// The boundaries between the parts 0 <= label, in order of (a, b). Lengths are those of the triangles' edges; what is
// pooled is asked of the patches. `averaged` is the charge averaged over balls, a patch.
std::vector<PartBoundary> ReportBoundaries(const PartSurface& surface, const std::vector<int>& labels,
                                           const Patches& patches, const std::vector<double>& averaged);

// A part's protrusion by charge: one minus the mean charge along its boundaries over the charge near its top (95 % of
// its area lie below), clipped to [0, 1]; 1 for a part without a boundary.
std::vector<double> ReportSignificance(const PartSurface& surface, const std::vector<int>& labels, int n_parts,
                                       const Patches& patches, const std::vector<double>& averaged);

}  // namespace geond
