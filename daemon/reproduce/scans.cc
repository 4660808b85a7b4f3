// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/scans.h"

#include <algorithm>

#include "calib/make_view.h"
#include "calib/register_views.h"
#include "core/picture/render.h"
#include "core/surface/integrate.h"

namespace geond::reproduce {
namespace {

SevenFits ByType(const std::vector<GeonFit>& fits) {
  SevenFits seven;
  for (const GeonFit& fit : fits) seven.fits[static_cast<std::size_t>(fit.geon.type) - 1] = fit;
  seven.chosen = static_cast<int>(fits.front().geon.type) - 1;
  return seven;
}

}  // namespace

std::vector<RangeView> ScanViews(const sim::Scene& scene, const ScanSettings& settings, const Run& run) {
  sim::SimOptions options;
  options.views = settings.views;
  options.first_angle = settings.first_angle;
  options.elevation = settings.elevation;
  options.distance = settings.distance;
  options.depth_noise = settings.noise;
  options.columns = options.rows = run.quick ? 160 : 320;
  options.seed = settings.seed;
  options.threads = run.threads;
  std::vector<RangeView> views = calib::MakeViews(sim::SimulateScan(scene, options, run.stop), {}, run.threads);
  if (views.size() > 1) {
    calib::RegisterOptions registration;
    registration.threads = run.threads;
    const calib::RegistrationResult registered = calib::RegisterViews(views, registration, run.stop);
    for (std::size_t i = 0; i < views.size(); ++i) views[i].X_TS = registered.X_TS[i];
  }
  return views;
}

PointCloud ThinnedCloud(const std::vector<RangeView>& views, int count, const Run& run) {
  IntegrateOptions options;
  options.threads = run.threads;
  const PointCloud all = IntegrateViews(views, options, run.stop);
  std::vector<int> kept;
  const double step = std::max(1.0, static_cast<double>(all.size()) / count);
  for (double at = 0.5 * step; at < static_cast<double>(all.size()); at += step) kept.push_back(static_cast<int>(at));
  return Select(all, kept);
}

SevenFits FitByAnnealing(const PointCloud& cloud, const VfsrOptions& options, std::uint64_t seed, const Run& run) {
  FitOptions fit;
  fit.optimizer = FitOptions::Optimizer::kVfsr;
  fit.vfsr = options;
  fit.seed = seed;
  fit.threads = run.threads;
  fit.fallback_ratio = 1.0;  // the least residual wins
  fit.fallback_distance = 0.0;
  fit.fallback_scatter_ratio = 0.0;
  fit.outline_of_one_view = false;
  return ByType(FitGeons(cloud, fit, run.stop));
}

SevenFits FitByDefault(const PointCloud& cloud, const Run& run) {
  FitOptions fit;
  fit.threads = run.threads;
  return ByType(FitGeons(cloud, fit, run.stop));
}

bool Contains(GeonType larger, GeonType smaller) { return larger != smaller && BaseType(larger) == smaller; }

Image FitPicture(const Geon& geon, const PointCloud& cloud, const Run& run) {
  Scene scene;
  CloudStyle dots;
  dots.color = {0.10f, 0.25f, 0.45f};
  dots.radius = 0.012 * geon.size.maxCoeff();
  scene.Add(cloud, dots);
  MeshStyle style;
  style.color = {0.93f, 0.78f, 0.55f};
  style.opacity = 0.55;
  scene.Add(GeonMesh(geon, 0.05 * geon.size.maxCoeff()), style);
  RenderOptions options;
  options.columns = 300;
  options.rows = 240;
  options.samples = 2;
  options.threads = run.threads;
  return Render(scene, Framing({&scene}, 0.6, 0.6, 300.0 / 240.0), options);
}

std::string PlainName(GeonType type) {
  std::string name(GeonTypeName(type));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace geond::reproduce
