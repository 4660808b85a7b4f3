// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/point_cloud.h"
#include "core/range/range_view.h"
#include "core/geometry/point_index.h"

namespace geond {

// The surface that noisy points with normals lie on, smooth but for its creases: a moving average of their planes in which
// only points count that agree on the normal (after Oztireli, Guennebaud and Gross 2009). Each plane is turned half way to
// the common normal, so that on a sphere the error of the second order cancels out.
class DataSurface {
 public:
  // Where a point comes to lie.
  struct Foot {
    Eigen::Vector3d point;
    Eigen::Vector3d normal;
    bool on_crease = false;      // two faces meet here
    Eigen::Vector3d along = Eigen::Vector3d::Zero();  // unit, along the crease
  };

  // `noise`: standard deviation of the points along their normals, m.
  DataSurface(PointCloud cloud, double noise, int threads);

  // The foot of p, where the mesh has this unit normal; none if there are no data near. Creases within `attraction` (m)
  // draw p on to their line.
  std::optional<Foot> Project(const Eigen::Vector3d& p, const Eigen::Vector3d& normal, double attraction) const;

  const PointCloud& cloud() const { return cloud_; }
  const PointIndex& index() const { return *index_; }

 private:
  PointCloud cloud_;
  std::unique_ptr<PointIndex> index_;
  double noise_;
  double spacing_;  // median distance that holds kNeighbors points, m
};

// All object data of the views in T. Near creases, where the plane of a pixel was fitted across the edge, the normal is that
// of the best-fitting plane of a neighbour which holds the pixel too (as Kuwahara's filter does).
PointCloud CreaseAwareCloud(std::span<const RangeView> views, int threads);

}  // namespace geond
