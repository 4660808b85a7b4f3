// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>
#include <vector>

#include "core/geon/fit.h"
#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/parts/segment.h"

namespace geond {

// The data of each part: the points of the cloud whose nearest triangle is the part's, without those closer than a mean
// edge to a cut (they belong to either). Points without normals take their triangle's.
std::vector<PointCloud> PartClouds(const PointCloud& cloud, const TriangleMesh& mesh,
                                   const PartSegmentation& segmentation);

// The places where each part is cut from its neighbours: the middles of the triangles' sides between them.
std::vector<std::vector<Eigen::Vector3d>> PartCuts(const TriangleMesh& mesh, const PartSegmentation& segmentation);

// FitGeons, or no fits at all if there are too few data.
std::vector<GeonFit> FitPart(const PointCloud& part, const Surroundings& around, const FitOptions& options,
                             std::stop_token stop);

}  // namespace geond
