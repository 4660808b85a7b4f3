// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/geon/fit.h"
#include "core/parts/segment.h"

namespace geond {

// A part and the geon that describes it. The fits are best first, fits[0] is the description.
struct DescribedPart {
  int id = 0;                    // from 1, largest area first
  std::vector<GeonFit> fits;
  double area = 0.0;             // of the part's surface, m^2
  double significance = 0.0;     // by charge, 0 to 1
  int points = 0;                // data the fit used
  const Geon& geon() const { return fits.front().geon; }
};

// How two parts sit together.
struct PartRelation {
  int a = 0, b = 0;                            // ids, a < b
  bool touching = false;                       // they share a boundary
  Eigen::Vector3d contact = Eigen::Vector3d::Zero();    // centre of that boundary, in T, m
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit, from the centre of a to that of b, in T
  double distance = 0.0;                       // between the centres, m
  double boundary_length = 0.0;                // m
  double boundary_strength = 0.0;
  double size_ratio = 1.0;                     // volume of a over that of b
  std::string vertical;                        // "above", "below" or "beside": b as seen from a
  std::string joint;                           // "end_to_end", "end_to_side", "side_to_end", "side_to_side"; first a's
  std::string sentence;                        // the same in words
};

struct ObjectDescription {
  std::vector<DescribedPart> parts;
  std::vector<PartRelation> relations;
  std::vector<std::pair<std::string, double>> seconds;  // step, wall time
  std::vector<std::string> notes;                       // what was assumed or should be known
};

// The mean distance of a part's data from its shape over their diagonal; above kPoorFit the shape does not describe them.
double ResidualShare(const GeonFit& fit, const PointCloud& part);
inline constexpr double kPoorFit = 0.03;

// The parts with their data and fits (a part; fits best first, none where it could not be fitted) and their relations.
// Throws std::invalid_argument if sizes do not fit.
ObjectDescription DescribeParts(const TriangleMesh& mesh, const PartSegmentation& segmentation,
                                const std::vector<PointCloud>& part_clouds,
                                const std::vector<std::vector<GeonFit>>& fits);

// "30.0 x 30.0 x at least 12.5": half sizes in mm with `digits` behind the point, with "at least" where an end is hidden.
std::string SizesInWords(const GeonFit& fit, int digits);

// The JSON of `geon describe --json` on one line: lengths in mm, quaternion w first, version.
std::string ToJson(const ObjectDescription& description);
// For a person: one line a part, one a relation.
std::string ToText(const ObjectDescription& description);

}  // namespace geond
