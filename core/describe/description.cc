// SPDX-License-Identifier: Apache-2.0
#include "core/describe/description.h"

#include <cmath>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "core/base/printed.h"
#include "core/describe/fit_json.h"
#include "core/describe/relations.h"

namespace geond {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMillimetres = 1e3;  // in a metre

Json ToArray(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json PoseToJson(const Pose& X_TG) {
  const Eigen::Quaterniond& q = X_TG.rotation();
  return {{"position_mm", ToArray(X_TG.translation() * kMillimetres)},
          {"quaternion", {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}}};
}

Json PartToJson(const DescribedPart& part) {
  const GeonFit& fit = part.fits.front();
  Json models = Json::array();
  for (const GeonFit& other : part.fits) {
    models.push_back({{"type", GeonTypeName(other.geon.type)},
                      {"residual_mm", FiniteOrNull(other.residual * kMillimetres)},
                      {"objective_mm", FiniteOrNull(other.objective * kMillimetres)}});
  }
  Json json{{"id", part.id},
            {"type", GeonTypeName(fit.geon.type)},
            {"type_index", static_cast<int>(fit.geon.type)},
            {"pose", PoseToJson(fit.geon.X_TG)},
            {"size_mm", ToArray(fit.geon.size * kMillimetres)},
            {"size_at_least", SizesAtLeast(fit)},
            {"ends", EndsToJson(fit)},
            {"taper", {fit.geon.taper.x(), fit.geon.taper.y()}},
            {"bend_per_mm", fit.geon.bend / kMillimetres},
            {"residual_mm", fit.residual * kMillimetres},
            {"t1_mm", fit.t1 * kMillimetres},
            {"t2", fit.t2},
            {"margin", FiniteOrNull(fit.margin)},
            {"confidence", fit.confidence},
            {"points", part.points},
            {"area_mm2", part.area * kMillimetres * kMillimetres},
            {"significance", part.significance},
            {"all_models", models}};
  if (fit.deviation.size() == 12) json["deviation"] = DeviationToJson(fit);
  return json;
}

Json RelationToJson(const PartRelation& relation) {
  return {{"a", relation.a},
          {"b", relation.b},
          {"touching", relation.touching},
          {"contact_mm", ToArray(relation.contact * kMillimetres)},
          {"direction", ToArray(relation.direction)},
          {"distance_mm", relation.distance * kMillimetres},
          {"boundary_length_mm", relation.boundary_length * kMillimetres},
          {"boundary_strength", relation.boundary_strength},
          {"size_ratio", relation.size_ratio},
          {"vertical", relation.vertical},
          {"joint", relation.joint},
          {"sentence", relation.sentence}};
}

}  // namespace

std::string SizesInWords(const GeonFit& fit, int digits) {
  const std::array<bool, 3> least = SizesAtLeast(fit);
  std::string text;
  for (int k = 0; k < 3; ++k) {
    text += Printed("%s%s%.*f", k == 0 ? "" : " x ", least[k] ? "at least " : "", digits, kMillimetres * fit.geon.size[k]);
  }
  return text;
}

double ResidualShare(const GeonFit& fit, const PointCloud& part) {
  return fit.residual / BoundingBox(part.points).diagonal().norm();
}

ObjectDescription DescribeParts(const TriangleMesh& mesh, const PartSegmentation& segmentation,
                                const std::vector<PointCloud>& part_clouds,
                                const std::vector<std::vector<GeonFit>>& fits) {
  if (static_cast<int>(fits.size()) != segmentation.n_parts || part_clouds.size() != fits.size() ||
      segmentation.labels.size() != mesh.triangles.size()) {
    throw std::invalid_argument("DescribeParts: fits, parts and triangles are not of one object");
  }
  ObjectDescription description;
  std::vector<double> area(segmentation.n_parts, 0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (segmentation.labels[t] >= 0) area[segmentation.labels[t]] += TriangleAreaVector(mesh, static_cast<int>(t)).norm();
  }
  for (int label = 0; label < segmentation.n_parts; ++label) {
    if (fits[label].empty()) {
      description.notes.push_back("part " + std::to_string(label + 1) + " has too few data to fit a shape to; left out");
      continue;
    }
    DescribedPart part;
    part.id = label + 1;
    part.fits = fits[label];
    part.area = area[label];
    part.points = static_cast<int>(part_clouds[label].size());
    if (const double share = ResidualShare(part.fits.front(), part_clouds[label]); share > kPoorFit) {
      description.notes.push_back(Printed("part %d is like none of the seven shapes: the nearest is off by %.0f %% of its size", part.id, 100.0 * share));
    }
    if (label < static_cast<int>(segmentation.significance.size())) part.significance = segmentation.significance[label];
    description.parts.push_back(std::move(part));
  }
  description.relations = RelateParts(mesh, segmentation, description.parts);
  return description;
}

std::string ToJson(const ObjectDescription& description) {
  Json parts = Json::array(), relations = Json::array(), seconds = Json::object();
  for (const DescribedPart& part : description.parts) parts.push_back(PartToJson(part));
  for (const PartRelation& relation : description.relations) relations.push_back(RelationToJson(relation));
  for (const auto& [step, time] : description.seconds) seconds[step] = time;
  return Json{{"n_parts", description.parts.size()}, {"parts", parts},   {"relations", relations},
              {"notes", description.notes},          {"seconds", seconds}, {"version", GEOND_VERSION}}
      .dump();
}

std::string ToText(const ObjectDescription& description) {
  const std::size_t n = description.parts.size();
  std::string text = Printed("%zu part%s\n", n, n == 1 ? "" : "s");
  for (const DescribedPart& part : description.parts) {
    const GeonFit& fit = part.fits.front();
    const Eigen::Vector3d at = fit.geon.X_TG.translation() * kMillimetres;
    text += Printed("  %d  %-16s  half sizes %s mm", part.id, std::string(GeonTypeName(fit.geon.type)).c_str(),
                   SizesInWords(fit, 1).c_str());
    if (IsTapered(fit.geon.type)) text += Printed(", taper %.2f %.2f", fit.geon.taper.x(), fit.geon.taper.y());
    if (IsCurved(fit.geon.type)) text += Printed(", bend radius %.1f mm", kMillimetres / fit.geon.bend);
    text += Printed(", at (%.1f %.1f %.1f) mm, residual %.2f mm, confidence %.2f\n", at.x(), at.y(), at.z(),
                   fit.residual * kMillimetres, fit.confidence);
  }
  for (const PartRelation& relation : description.relations) text += "  " + relation.sentence + "\n";
  for (const std::string& note : description.notes) text += "  note: " + note + "\n";
  return text;
}

}  // namespace geond
