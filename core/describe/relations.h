// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/describe/description.h"

namespace geond {

// Volume of a geon with sharp edges, m^3: tapering multiplies by 1 + Kx Ky / 3, bending leaves it (Pappus).
double GeonVolume(const Geon& geon);

// Whether a point of the geon (in T, on or in it) lies towards an end of its axis rather than on its side. Shapes without
// a distinct axis (extents alike within 15 %) are all end.
bool IsAtEnd(const Geon& geon, const Eigen::Vector3d& p_T);

// The relations of all parts that touch; a part that touches none is related to the nearest one.
std::vector<PartRelation> RelateParts(const TriangleMesh& mesh, const PartSegmentation& segmentation,
                                      const std::vector<DescribedPart>& parts);

}  // namespace geond
