// SPDX-License-Identifier: Apache-2.0
#include "core/object_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "core/base/printed.h"
#include "core/empty_places.h"
#include "core/geometry/cloud_normals.h"
#include "core/geometry/sample_mesh.h"
#include "core/geometry/stray_points.h"
#include "core/hollow_part.h"
#include "core/part_clouds.h"
#include "core/surface/close_mesh.h"
#include "core/surface/remesh.h"

namespace geond {
namespace {

// Points sampled from a mesh that came without data of its own.
constexpr int kMeshSamples = 20'000;
// A closed mesh is taken as it is within these numbers of triangles and above this least angle (rad); else remeshed.
constexpr int kFewestTriangles = 800, kMostTriangles = 6'000;
constexpr double kLeastAngle = 0.17;

// Times the steps, reports them, and ends the work between two of them if asked to.
class Steps {
 public:
  Steps(const std::stop_token& stop, const StepObserver& on_step) : stop_(stop), on_step_(on_step) {}

  void operator()(const char* name) {
    ThrowIfStopped(stop_);
    End();
    seconds_.emplace_back(name, 0.0);
    if (on_step_) on_step_(name, 0, 0);
  }
  void Progress(int done, int total) const {
    if (on_step_) on_step_(seconds_.back().first, done, total);
  }
  std::vector<std::pair<std::string, double>> Seconds() {
    End();
    return seconds_;
  }
  const std::stop_token& stop() const { return stop_; }

 private:
  using Clock = std::chrono::steady_clock;
  void End() {
    const Clock::time_point now = Clock::now();
    if (!seconds_.empty()) seconds_.back().second += std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
  }

  std::stop_token stop_;
  const StepObserver& on_step_;
  std::vector<std::pair<std::string, double>> seconds_;
  Clock::time_point begin_;
};

// Places about a part of which it is known that they are empty.
using FindEmpty = std::function<std::vector<Eigen::Vector3d>(const PointCloud& part)>;

// The steps that every kind of input shares, from a closed mesh and its data to the description.
void DescribeSurface(ObjectModel& model, const ModelOptions& options, const FindEmpty& find_empty, Steps& step) {
  step("charge");
  model.charge = SolveChargeDensity(model.mesh, options.charge, step.stop());
  step("segment");
  model.segmentation = SegmentParts(model.mesh, model.charge, options.segment, step.stop());
  step("fit");
  model.part_clouds = PartClouds(model.cloud, model.mesh, model.segmentation);
  const std::vector<std::vector<Eigen::Vector3d>> cuts = PartCuts(model.mesh, model.segmentation);
  std::vector<std::string> notes;
  for (int part = 0; part < model.segmentation.n_parts; ++part) {
    step.Progress(part, model.segmentation.n_parts);
    PointCloud& cloud = model.part_clouds[part];
    std::vector<GeonFit>& fits = model.fits.emplace_back();
    fits = FitPart(cloud, {find_empty(cloud), cuts[part]}, options.fit, step.stop());
    if (fits.empty() || ResidualShare(fits.front(), cloud) <= kPoorFit) continue;
    // Geons are solid: of a vessel they can be no more than the outside.
    PointCloud outside = OutsideOfPart(model.cloud, model.mesh, model.segmentation, part);
    std::vector<GeonFit> shell = FitPart(outside, {{}, cuts[part]}, options.fit, step.stop());
    if (shell.empty() || ResidualShare(shell.front(), outside) > kPoorFit) continue;
    cloud = std::move(outside);
    fits = std::move(shell);
    notes.push_back(Printed("part %d is hollow: its shape is that of its outside", part + 1));
  }
  step("describe");
  model.description = DescribeParts(model.mesh, model.segmentation, model.part_clouds, model.fits);
  model.description.notes.insert(model.description.notes.end(), notes.begin(), notes.end());
}

// The whole cloud as one part, without a mesh: for data seen from one side only.
void DescribeOnePart(ObjectModel& model, const ModelOptions& options, Steps& step) {
  step("fit");
  model.segmentation.n_parts = 1;
  model.segmentation.significance = {1.0};
  model.part_clouds = {model.cloud};
  model.fits = {FitPart(model.cloud, {}, options.fit, step.stop())};
  if (model.fits[0].empty()) throw std::invalid_argument("too few points with normals to fit a shape to");
  step("describe");
  model.description = DescribeParts(model.mesh, model.segmentation, model.part_clouds, model.fits);
}

bool SuitsChargeSolve(const TriangleMesh& mesh) {
  const int n = static_cast<int>(mesh.triangles.size());
  return n >= kFewestTriangles && n <= kMostTriangles && MinAngle(mesh) >= kLeastAngle;
}

// So that the mesh of one view has some ten thousand triangles on its seen side, whatever the camera's pixels.
int StepOfPixels(const PointCloud& cloud) {
  constexpr double kMostPixels = 10000.0;
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(cloud.size()) / kMostPixels))));
}

void Finish(ObjectModel& model, Steps& step, const std::vector<std::string>& notes) {
  model.description.seconds = step.Seconds();
  model.description.notes.insert(model.description.notes.begin(), notes.begin(), notes.end());
}

}  // namespace

ObjectModel BuildObjectModel(std::span<const RangeView> views, const ModelOptions& options, std::stop_token stop,
                             const StepObserver& on_step) {
  Steps step(stop, on_step);
  ObjectModel model;
  step("integrate");
  model.cloud = IntegrateViews(views, options.integrate, stop);
  step("tessellate");
  model.mesh = views.size() == 1 ? Transform(views[0].X_TS, TessellateView(views[0], {.step = StepOfPixels(model.cloud)}))
                                 : Tessellate(views, model.cloud, options.tessellate, stop);
  const bool on_table = options.tessellate.close_on_table;
  DescribeSurface(model, options, [&](const PointCloud& part) { return EmptyPlaces(views, on_table, part); }, step);
  Finish(model, step, {});
  return model;
}

ObjectModel BuildObjectModel(const PointCloud& cloud, const ModelOptions& options, std::stop_token stop,
                             const StepObserver& on_step) {
  Steps step(stop, on_step);
  ObjectModel model;
  std::vector<std::string> notes;
  step("tessellate");
  model.cloud = WithoutStrayPoints(cloud, 0.02, &notes);
  try {
    model.mesh = TessellateCloud(model.cloud, options.tessellate, stop);
  } catch (const std::invalid_argument& refusal) {
    // What cannot be closed (one side of a body, say) can still be one part.
    notes.push_back(std::string(refusal.what()) + "; described as one part");
    model.cloud = WithOutwardNormals(model.cloud, &notes);
  }
  if (model.mesh.empty()) {
    DescribeOnePart(model, options, step);
  } else {
    // The mesh is a guess where there were no points: it does not say what is empty.
    DescribeSurface(model, options, [](const PointCloud&) { return std::vector<Eigen::Vector3d>(); }, step);
  }
  Finish(model, step, notes);
  return model;
}

ObjectModel BuildObjectModel(const TriangleMesh& mesh, const ModelOptions& options, std::stop_token stop,
                             const StepObserver& on_step) {
  CheckMesh(mesh);
  Steps step(stop, on_step);
  ObjectModel model;
  std::vector<std::string> notes;
  step("tessellate");
  const MeshTopology topology = Topology(mesh);
  const bool sound = topology.closed && topology.manifold && Volume(mesh) > 0.0;
  if (sound && SuitsChargeSolve(mesh)) {
    model.mesh = mesh;
  } else if (sound) {
    model.mesh = Remesh(mesh, {.triangles = options.tessellate.triangles, .edge_length = options.tessellate.edge_length}, stop);
  } else {
    model.mesh = CloseMesh(mesh, options.tessellate, stop);
    notes.push_back("the mesh was not closed and manifold; its closed hull by winding number was described");
  }
  model.cloud = SampleMesh(sound ? mesh : model.mesh, kMeshSamples, /*only_seen=*/true);
  const auto find_empty = [&](const PointCloud& part) {
    return sound ? EmptyPlaces(mesh, part) : std::vector<Eigen::Vector3d>();
  };
  DescribeSurface(model, options, find_empty, step);
  Finish(model, step, notes);
  return model;
}

}  // namespace geond
