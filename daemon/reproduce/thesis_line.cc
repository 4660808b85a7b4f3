// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/thesis_line.h"

#include <algorithm>
#include <limits>
#include <map>

namespace geond::reproduce {

TriangleMesh SeenPatch(const TriangleMesh& closed, std::vector<double>& density) {
  TriangleMesh patch;
  std::vector<double> kept;
  std::map<int, int> places;
  for (std::size_t t = 0; t < closed.triangles.size(); ++t) {
    if (!closed.triangle_seen.empty() && !closed.triangle_seen[t]) continue;
    TriangleMesh::Triangle triangle = closed.triangles[t];
    for (int& v : triangle) {
      const auto [at, fresh] = places.try_emplace(v, static_cast<int>(patch.vertices.size()));
      if (fresh) patch.vertices.push_back(closed.vertices[static_cast<std::size_t>(v)]);
      v = at->second;
    }
    patch.triangles.push_back(triangle);
    kept.push_back(density[t]);
  }
  density = std::move(kept);
  return patch;
}

ThesisModel RunThesisLine(const TriangleMesh& closed, bool one_view, bool with_fits, const Run& run) {
  ThesisModel model;
  ChargeOptions exact;
  exact.solver = ChargeOptions::Solver::kDense;
  exact.threads = run.threads;
  ChargeDensity charge = SolveChargeDensity(closed, exact, run.stop);
  model.mesh = one_view ? SeenPatch(closed, charge.density) : closed;
  if (!one_view) model.mesh.triangle_seen.clear();
  SegmentOptions trace;
  trace.method = SegmentOptions::Method::kTrace;
  model.parts = SegmentParts(model.mesh, charge, trace, run.stop);
  model.density = charge.density;
  if (!with_fits) return model;
  std::vector<PointCloud> clouds(static_cast<std::size_t>(model.parts.n_parts));
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(model.mesh);
  for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
    if (model.parts.labels[t] < 0) continue;
    if (!one_view && !closed.triangle_seen.empty() && !closed.triangle_seen[t]) continue;
    PointCloud& cloud = clouds[static_cast<std::size_t>(model.parts.labels[t])];
    cloud.points.push_back(TriangleCentroid(model.mesh, static_cast<int>(t)));
    cloud.normals.push_back(normals[t]);
  }
  for (const PointCloud& cloud : clouds) {
    model.fits.emplace_back();
    if (cloud.size() >= 12) model.fits.back() = FitByAnnealing(cloud, {}, 1, run);
  }
  return model;
}

std::vector<std::optional<Geon>> MatchedParts(const sim::Scene& scene, const std::vector<Geon>& found) {
  std::vector<std::optional<Geon>> matched(scene.parts.size());
  std::vector<bool> taken(found.size(), false);
  for (std::size_t round = 0; round < std::min(scene.parts.size(), found.size()); ++round) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t part = 0, geon = 0;
    for (std::size_t i = 0; i < scene.parts.size(); ++i) {
      if (matched[i]) continue;
      for (std::size_t j = 0; j < found.size(); ++j) {
        const double distance = (Canonical(scene.parts[i].geon).X_TG.translation() - found[j].X_TG.translation()).norm();
        if (!taken[j] && distance < least) least = distance, part = i, geon = j;
      }
    }
    matched[part] = found[geon];
    taken[geon] = true;
  }
  return matched;
}

std::vector<Geon> ChosenGeons(const ObjectDescription& description) {
  std::vector<Geon> geons;
  for (const DescribedPart& part : description.parts) {
    if (!part.fits.empty()) geons.push_back(part.geon());
  }
  return geons;
}

std::vector<Geon> ChosenGeons(const ThesisModel& model) {
  std::vector<Geon> geons;
  for (const std::optional<SevenFits>& fits : model.fits) {
    if (fits) geons.push_back(fits->fits[static_cast<std::size_t>(fits->chosen)].geon);
  }
  return geons;
}

int TypesRight(const sim::Scene& scene, const std::vector<Geon>& found) {
  const std::vector<std::optional<Geon>> matched = MatchedParts(scene, found);
  int right = 0;
  for (std::size_t i = 0; i < matched.size(); ++i) right += matched[i] && matched[i]->type == scene.parts[i].geon.type;
  return right;
}

std::string NamesOf(const std::vector<Geon>& geons) {
  std::string names;
  for (const Geon& geon : geons) names += (names.empty() ? "" : " + ") + PlainName(geon.type);
  return names;
}

}  // namespace geond::reproduce
