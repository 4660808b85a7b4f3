// SPDX-License-Identifier: Apache-2.0
// Tips and edges: hills of the charge density.
#include "core/parts/convex_features.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>

#include "core/parts/part_surface.h"
#include "core/parts/patches.h"
#include "core/parts/trace.h"
#include "core/parts/watershed.h"

namespace geond {
namespace {

constexpr int kPatches = 5000;
constexpr double kLongOverWide = 3.0;
// Two hills are one if the pass between them lies this high: the share of the lower top.
constexpr double kSamePlace = 0.85;

// Hills of `height` among the pieces that are high, those with hardly a saddle between them joined; -1 elsewhere.
std::vector<int> Hills(const SurfaceGraph& surface, const std::vector<double>& height, double least) {
  std::vector<int> labels = Watershed(surface, height);
  std::vector<double> top(1 + *std::max_element(labels.begin(), labels.end()), 0.0);
  for (int t = 0; t < surface.n(); ++t) {
    top[labels[t]] = std::max(top[labels[t]], height[t]);
    if (height[t] < least) labels[t] = -1;
  }
  std::vector<int> root(top.size());
  for (std::size_t i = 0; i < root.size(); ++i) root[i] = static_cast<int>(i);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i];
    return i;
  };
  struct Pass {
    double height;
    int a, b;
  };
  std::vector<Pass> passes;
  for (int t = 0; t < surface.n(); ++t) {
    for (int next : surface.Neighbors(t)) {
      if (next < t || labels[t] < 0 || labels[next] < 0 || labels[t] == labels[next]) continue;
      passes.push_back({std::min(height[t], height[next]), labels[t], labels[next]});
    }
  }
  std::stable_sort(passes.begin(), passes.end(), [](const Pass& p, const Pass& q) { return p.height > q.height; });
  for (const Pass& pass : passes) {  // the highest first, so that hills join the way water would part them
    const int a = find(pass.a), b = find(pass.b);
    if (a == b || pass.height < kSamePlace * std::min(top[a], top[b])) continue;
    root[std::max(a, b)] = std::min(a, b);
    top[std::min(a, b)] = std::max(top[a], top[b]);
  }
  for (int& label : labels) label = label < 0 ? -1 : find(label);
  return labels;
}

}  // namespace

std::vector<ConvexFeature> FindConvexFeatures(const TriangleMesh& mesh, const ChargeDensity& charge,
                                              const ConvexFeatureOptions& options) {
  CheckMesh(mesh);
  if (charge.density.size() != mesh.triangles.size()) {
    throw std::invalid_argument("FindConvexFeatures: the charge has " + std::to_string(charge.density.size()) +
                                " values, the mesh " + std::to_string(mesh.triangles.size()) + " triangles");
  }
  if (mesh.empty()) return {};
  const PartSurface surface = MakePartSurface(mesh);
  const Patches patches = MakePatches(surface.graph, kPatches);
  const SurfaceGraph& graph = patches.graph;
  if (!(graph.area > 0.0)) return {};
  std::vector<double> density(surface.n());
  for (int t = 0; t < surface.n(); ++t) density[t] = charge.density[surface.source[t]];
  const std::vector<double> height = BallMean(graph, MeanOfPatches(surface.graph, patches, density),
                                              std::max(options.radius * graph.size, graph.edge));
  const double median = MedianByArea(graph, height);
  if (!(median > 0.0)) return {};
  const std::vector<int> hills = Hills(graph, height, options.least * median);

  std::vector<std::vector<int>> pieces(1 + *std::max_element(hills.begin(), hills.end()));
  for (int p = 0; p < graph.n(); ++p) {
    if (hills[p] >= 0) pieces[hills[p]].push_back(p);
  }
  std::vector<std::vector<int>> triangles(pieces.size());
  for (int t = 0; t < surface.n(); ++t) {
    if (hills[patches.of[t]] >= 0) triangles[hills[patches.of[t]]].push_back(surface.source[t]);
  }
  std::vector<ConvexFeature> features;
  for (std::size_t hill = 0; hill < pieces.size(); ++hill) {
    if (pieces[hill].empty()) continue;
    int top = pieces[hill].front();
    double area = 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), outward = Eigen::Vector3d::Zero();
    for (int p : pieces[hill]) {
      if (height[p] > height[top]) top = p;
      area += graph.areas[p];
      middle += graph.areas[p] * graph.centroids[p];
      outward += graph.area_vectors[p];
    }
    if (height[top] < options.least_top * median || !(area > 0.0)) continue;
    middle /= area;
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int p : pieces[hill]) {
      const Eigen::Vector3d d = graph.centroids[p] - middle;
      spread += graph.areas[p] / area * d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
    const Eigen::Vector3d wide = axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    const Eigen::Vector3d along = axes.eigenvectors().col(2);
    ConvexFeature feature;
    double low = 0.0, high = 0.0;
    for (int p : pieces[hill]) {
      const double x = along.dot(graph.centroids[p] - middle);
      low = std::min(low, x);
      high = std::max(high, x);
    }
    feature.length = high - low;
    feature.kind = wide[2] > kLongOverWide * wide[1] ? ConvexFeature::Kind::kEdge : ConvexFeature::Kind::kTip;
    const bool edge = feature.kind == ConvexFeature::Kind::kEdge;
    feature.position = edge ? middle : graph.centroids[top];
    feature.direction = edge ? along : outward.stableNormalized();
    feature.strength = height[top] / median;
    feature.triangles = std::move(triangles[hill]);
    std::sort(feature.triangles.begin(), feature.triangles.end());
    features.push_back(std::move(feature));
  }
  std::stable_sort(features.begin(), features.end(),
                   [](const ConvexFeature& a, const ConvexFeature& b) { return a.strength > b.strength; });
  return features;
}

}  // namespace geond
