// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <stop_token>
#include <vector>

#include "core/base/progress.h"
#include "core/charge/charge_density.h"
#include "core/describe/description.h"
#include "core/geon/fit.h"
#include "core/parts/segment.h"
#include "core/range/range_view.h"
#include "core/surface/integrate.h"
#include "core/surface/tessellate.h"

namespace geond {

struct ModelOptions {
  IntegrateOptions integrate;
  TessellateOptions tessellate;
  ChargeOptions charge;
  SegmentOptions segment;
  FitOptions fit;
};

// All that was made on the way from data to description, in T. Each value is made once and read by the steps after it.
struct ObjectModel {
  PointCloud cloud;
  TriangleMesh mesh;
  ChargeDensity charge;
  PartSegmentation segmentation;
  std::vector<PointCloud> part_clouds;      // a part: the data its fit used
  std::vector<std::vector<GeonFit>> fits;   // a part, best first
  ObjectDescription description;
};

// The line from registered views to the description.
ObjectModel BuildObjectModel(std::span<const RangeView> views, const ModelOptions& options = {},
                             std::stop_token stop = {}, const StepObserver& on_step = {});
// The same from a bare cloud: with its surface closed if it goes round, else as one part.
ObjectModel BuildObjectModel(const PointCloud& cloud, const ModelOptions& options = {}, std::stop_token stop = {},
                             const StepObserver& on_step = {});
// The same from a mesh: remeshed where its triangles do not suit the charge; closed by way of a cloud if it is open.
ObjectModel BuildObjectModel(const TriangleMesh& mesh, const ModelOptions& options = {}, std::stop_token stop = {},
                             const StepObserver& on_step = {});

}  // namespace geond
