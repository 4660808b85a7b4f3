// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace geond::charge {

// The charge of a conductor has one sign; collocation gives a few triangles beside sharp creases the other. Each of them
// gets 0 and its neighbours across edges bear what it lacks, in proportion to their charge; the total stays. As near the truth
// as a solve under the condition that no density be negative (tests/validation/charge_creases_validation.cc). Returns how
// many were negative.
std::size_t MakeOneSign(const TriangleMesh& mesh, std::span<const double> areas, std::vector<double>& density);

}  // namespace geond::charge
