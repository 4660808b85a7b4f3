// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/range/range_view.h"

namespace geond {

// Places in T in and about the box of a part where certainly nothing is, some spread evenly, more of them near its
// points: a view looked through them at something behind, clearly and with all pixels around; or they lie under the
// table that the object stands on, if it does. Deterministic.
std::vector<Eigen::Vector3d> EmptyPlaces(std::span<const RangeView> views, bool on_table, const PointCloud& part);

// The same of a closed mesh that is the whole truth: places outside it.
std::vector<Eigen::Vector3d> EmptyPlaces(const TriangleMesh& closed, const PointCloud& part);

}  // namespace geond
