// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>

#include "core/base/printed.h"
#include "core/parts/convex_features.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {
namespace {

// One label a line, as the Princeton segmentation benchmark has it.
void WriteLabels(const std::vector<int>& labels, const std::filesystem::path& path) {
  std::ofstream file(path);
  for (const int label : labels) file << label << '\n';
  file.close();
  if (!file) throw FileError(path.string(), "write", "it cannot be written", "Check the folder and the space left");
}

}  // namespace

CommandResult Segment(const SegmentArguments& arguments, const CommandContext& context) {
  const Stopwatch watch;
  const Input input = ReadInput(arguments.input, arguments.unit);
  const TriangleMesh& mesh = MeshOf(input);
  PartSegmentation parts;
  std::vector<ConvexFeature> features;
  try {
    const ChargeDensity charge = SolveChargeDensity(mesh, arguments.charge, context.stop, context.on_step);
    if (context.on_step) context.on_step("segment", 0, 0);
    parts = SegmentParts(mesh, charge, arguments.options, context.stop);
    features = FindConvexFeatures(mesh, charge);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "segment", error.what());
  }
  if (!arguments.seg.empty()) WriteLabels(parts.labels, arguments.seg);
  Json boundaries = Json::array();
  for (const PartBoundary& boundary : parts.boundaries) {
    boundaries.push_back({{"a", boundary.a},
                          {"b", boundary.b},
                          {"length_mm", 1e3 * boundary.length},
                          {"closed", boundary.closed},
                          {"strength", boundary.strength},
                          {"concavity", boundary.concavity},
                          {"contrast", boundary.contrast}});
  }
  Json tips_and_edges = Json::array();
  for (const ConvexFeature& feature : features) {
    const Eigen::Vector3d position_mm = 1e3 * feature.position;
    tips_and_edges.push_back(
        {{"kind", feature.kind == ConvexFeature::Kind::kTip ? "tip" : "edge"},
         {"position_mm", {position_mm.x(), position_mm.y(), position_mm.z()}},
         {"direction", {feature.direction.x(), feature.direction.y(), feature.direction.z()}},
         {"length_mm", 1e3 * feature.length},
         {"strength", feature.strength},
         {"part", parts.labels[feature.triangles.front()]}});
  }
  CommandResult result;
  result.json = {{"n_parts", parts.n_parts},
                 {"n_triangles", mesh.triangles.size()},
                 {"labels", parts.labels},
                 {"boundaries", std::move(boundaries)},
                 {"significance", parts.significance},
                 {"features", std::move(tips_and_edges)},
                 {"message", parts.message},
                 {"seconds", watch.seconds()}};
  result.text = Printed("%d part%s", parts.n_parts, parts.n_parts == 1 ? "" : "s");
  for (int part = 0; part < parts.n_parts; ++part) {
    result.text += Printed("\n  part %d: %td triangles", part,
                          std::count(parts.labels.begin(), parts.labels.end(), part));
  }
  for (const PartBoundary& boundary : parts.boundaries) {
    result.text += Printed("\n  %d meets %d over %.1f mm%s, strength %.2f", boundary.a, boundary.b,
                          1e3 * boundary.length, boundary.closed ? "" : " (open)", boundary.strength);
  }
  AddNotes(input, result);
  return result;
}

}  // namespace geond::daemon
