// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "core/charge/charge_density.h"
#include "core/describe/description.h"
#include "core/parts/segment.h"
#include "daemon/reproduce/scans.h"

namespace geond::reproduce {

// The thesis' own line from a mesh to geons, with its errors corrected: exact dense charge, boundaries traced along valleys of
// charge (D.2, D.3), each part's triangles as data (centroids and normals, 6.5), annealing alone, the least residual wins.
struct ThesisModel {
  TriangleMesh mesh;                // what was cut: for one view its seen surface only
  std::vector<double> density;      // a triangle, for unit charge, 1/m^2
  PartSegmentation parts;
  std::vector<std::optional<SevenFits>> fits;  // a part; none where it has too few triangles
};
ThesisModel RunThesisLine(const TriangleMesh& closed, bool one_view, bool with_fits, const Run& run);

// The seen triangles of a mesh of one view, with the vertices they use; `density` is cut down likewise.
TriangleMesh SeenPatch(const TriangleMesh& closed, std::vector<double>& density);

// The parts of a scene as they were found: for each true part the found geon whose centre is nearest to its own, each at
// most once; none where too few were found.
std::vector<std::optional<Geon>> MatchedParts(const sim::Scene& scene, const std::vector<Geon>& found);

// The geons a description, or the thesis' line, chose.
std::vector<Geon> ChosenGeons(const ObjectDescription& description);
std::vector<Geon> ChosenGeons(const ThesisModel& model);

// Parts found whose type is the true one.
int TypesRight(const sim::Scene& scene, const std::vector<Geon>& found);

// "ellipsoid + tapered cylinder".
std::string NamesOf(const std::vector<Geon>& geons);

}  // namespace geond::reproduce
