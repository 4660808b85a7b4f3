// SPDX-License-Identifier: Apache-2.0
// Simulates the sample scenes, sends them through the whole line and says, step by step, how far each result is from
// the truth.  sim_scenes_validation [--views 4,8] [--seeds 1,2] [--noise_mm 0.3] [--mixed 0.05] [--write FOLDER]
// [--images_only] [SCENE...]
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "calib/make_view.h"
#include "calib/register_views.h"
#include "core/object_model.h"
#include "sim/simulate_scan.h"

namespace {

using namespace geond;
namespace fs = std::filesystem;

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<int> Integers(const std::string& list) {
  std::vector<int> values;
  std::stringstream in(list);
  for (std::string item; std::getline(in, item, ',');) values.push_back(std::stoi(item));
  return values;
}

// Signed distance of points to the true union, to first order; negative inside.
class Truth {
 public:
  explicit Truth(const sim::Scene& scene) {
    for (const auto& part : scene.parts) surfaces_.emplace_back(part.geon);
  }
  double Distance(const Eigen::Vector3d& p_T) const {
    double nearest = 1.0;
    for (const auto& surface : surfaces_) {
      const auto value = surface.At(p_T);
      nearest = std::min(nearest, (value.value - 1.0) / std::max(value.gradient.norm(), 1e-3));
    }
    return nearest;
  }
  struct Statistics {
    double mean = 0.0, rms = 0.0, worst = 0.0;
  };
  Statistics Of(const std::vector<Eigen::Vector3d>& points, double above) const {
    Statistics s;
    int n = 0;
    for (const auto& p : points) {
      if (p.z() < above) continue;
      const double d = 1e3 * Distance(p);
      s.mean += d, s.rms += d * d, s.worst = std::max(s.worst, std::abs(d)), ++n;
    }
    s.mean /= std::max(n, 1), s.rms = std::sqrt(s.rms / std::max(n, 1));
    return s;
  }

 private:
  std::vector<sim::GeonSurface> surfaces_;
};

std::string PrintGeon(const Geon& geon) {
  char text[200];
  std::snprintf(text, sizeof text, "%-16s %5.1f %5.1f %5.1f  K %.2f %.2f  bend %.4f/mm  at %.1f %.1f %.1f",
                std::string(GeonTypeName(geon.type)).c_str(), 1e3 * geon.size.x(), 1e3 * geon.size.y(),
                1e3 * geon.size.z(), geon.taper.x(), geon.taper.y(), 1e-3 * geon.bend,
                1e3 * geon.X_TG.translation().x(), 1e3 * geon.X_TG.translation().y(),
                1e3 * geon.X_TG.translation().z());
  return text;
}

// Of each true part the described part nearest to it; right if the types agree. The error of the sizes is that of the
// canonical half sizes, the worst of the three.
struct Verdict {
  bool count = false, types = false;
  double size_error = 0.0;
};

Verdict Judge(const sim::Scene& scene, const ObjectDescription& description) {
  Verdict verdict;
  verdict.count = description.parts.size() == scene.parts.size();
  verdict.types = verdict.count;
  for (const auto& part : description.parts) {
    if (verdict.count || part.fits.empty()) continue;
    std::printf("      part  %d  area %.0f mm^2, %d points, %s\n", part.id, 1e6 * part.area, part.points,
                PrintGeon(part.geon()).c_str());
  }
  for (const auto& part : scene.parts) {
    const Geon truth = Canonical(part.geon);
    const DescribedPart* nearest = nullptr;
    double distance = 1e9;
    for (const auto& candidate : description.parts) {
      if (candidate.fits.empty()) continue;
      const double d = (candidate.geon().X_TG.translation() - truth.X_TG.translation()).norm();
      if (d < distance) distance = d, nearest = &candidate;
    }
    std::printf("      true  %s  (%s)\n", PrintGeon(truth).c_str(), part.name.c_str());
    if (!nearest) {
      verdict.types = false;
      continue;
    }
    const Geon found = Canonical(nearest->geon());
    const GeonFit& fit = nearest->fits.front();
    std::printf("      found %s  residual %.3f mm, margin %.2f, %d points\n", PrintGeon(found).c_str(),
                1e3 * fit.residual, fit.margin, nearest->points);
    if (found.type != truth.type) {
      verdict.types = false;
      for (const GeonFit& other : nearest->fits) {
        std::printf("        %-16s E %.4f t1 %.4f mm t2 %.4f\n", std::string(GeonTypeName(other.geon.type)).c_str(),
                    1e3 * other.objective, 1e3 * other.t1, other.t2);
      }
      continue;
    }
    Eigen::Vector3d a = truth.size, b = found.size;
    std::sort(a.data(), a.data() + 3);
    std::sort(b.data(), b.data() + 3);
    verdict.size_error = std::max(verdict.size_error, (b - a).cwiseAbs().cwiseQuotient(a).maxCoeff());
  }
  return verdict;
}

// Largest distance between refined and true sensor poses, relative to the first view's, at the object's height.
double PoseError(const RecordedScan& scan, const std::vector<Pose>& X_TS, const sim::SimOptions& options) {
  StationGeometry truth = scan.station;
  truth.X_WT = scan.station.X_WT * sim::AxisErrorPose(options.axis_error);
  double worst = 0.0;
  const Pose first = X_TS[0] * Inverse(SensorInTurntable(truth, scan.views[0].exposure.table_angle));
  for (std::size_t i = 1; i < X_TS.size(); ++i) {
    const Pose error = Inverse(first) * X_TS[i] * Inverse(SensorInTurntable(truth, scan.views[i].exposure.table_angle));
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.05, 0, 0), Eigen::Vector3d(0, 0.05, 0.1)}) {
      worst = std::max(worst, (error * p - p).norm());
    }
  }
  return worst;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> views{4, 8}, seeds{1};
  double noise = 0.3, mixed = sim::CameraOptions{}.mixed_pixel_probability;
  fs::path folder;
  bool images_only = false;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string next = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--views")
      views = Integers(next), ++i;
    else if (word == "--seeds")
      seeds = Integers(next), ++i;
    else if (word == "--noise_mm")
      noise = std::stod(next), ++i;
    else if (word == "--mixed")
      mixed = std::stod(next), ++i;
    else if (word == "--write")
      folder = next, ++i;
    else if (word == "--images_only")
      images_only = true;
    else
      names.push_back(word);
  }
  if (names.empty()) {
    for (const auto& entry : fs::directory_iterator(GEOND_SOURCE_DIR "/config/scenes"))
      names.push_back(entry.path().stem());
    std::sort(names.begin(), names.end());
  }
  int right = 0, runs = 0;
  std::string summary;
  for (const std::string& name : names) {
    const sim::Scene scene = sim::ReadScene(fs::path(GEOND_SOURCE_DIR "/config/scenes") / (name + ".toml"));
    const Truth truth(scene);
    for (const int n : views) {
      for (const int seed : seeds) {
        sim::SimOptions options;
        options.views = n;
        options.seed = static_cast<std::uint64_t>(seed);
        options.depth_noise = 1e-3 * noise;
        options.camera.mixed_pixel_probability = mixed;
        double clock = CpuSeconds();
        const auto lap = [&] {
          const double now = CpuSeconds(), passed = now - clock;
          clock = now;
          return passed;
        };
        const RecordedScan scan = sim::SimulateScan(scene, options);
        std::printf("%s, %d views, seed %d: simulate %.2f s\n", name.c_str(), n, seed, lap());
        if (!folder.empty()) WriteScan(scan, folder / (name + "_" + std::to_string(n) + "_" + std::to_string(seed)));
        if (images_only) continue;
        char line[200];
        ++runs;
        try {
          std::vector<RangeView> range_views = calib::MakeViews(scan);
          std::printf("   views    %.2f s, points", lap());
          for (const auto& view : range_views) std::printf(" %zu", ViewCloud(view).size());
          std::vector<Pose> measured, refined;
          for (const auto& view : range_views) measured.push_back(view.X_TS);
          const auto registration = calib::RegisterViews(range_views);
          std::printf("\n   register %.2f s, rms %.3f -> %.3f mm, poses off by %.3f -> %.3f mm\n", lap(),
                      1e3 * registration.rms_before, 1e3 * registration.rms_after,
                      1e3 * PoseError(scan, measured, options), 1e3 * PoseError(scan, registration.X_TS, options));
          for (std::size_t i = 0; i < range_views.size(); ++i) range_views[i].X_TS = registration.X_TS[i];
          const ObjectModel model = BuildObjectModel(range_views);
          std::printf("   model    %.2f s:", lap());
          for (const auto& [step, seconds] : model.description.seconds) std::printf(" %s %.2f", step.c_str(), seconds);
          const auto c = truth.Of(model.cloud.points, 0.0), m = truth.Of(model.mesh.vertices, 0.003);
          std::printf("\n   cloud    %zu points, off the truth by mean %.3f rms %.3f worst %.2f mm\n",
                      model.cloud.size(), c.mean, c.rms, c.worst);
          const MeshTopology topology = Topology(model.mesh);
          std::printf(
              "   mesh     %zu triangles, closed %d manifold %d components %d genus %d, mean %.3f rms %.3f worst %.2f "
              "mm\n",
              model.mesh.triangles.size(), topology.closed, topology.manifold, topology.components, topology.genus,
              m.mean, m.rms, m.worst);
          const Verdict verdict = Judge(scene, model.description);
          right += verdict.count && verdict.types;
          std::snprintf(line, sizeof line,
                        "%-18s %d views seed %d  parts %zu of %zu  types %s  worst size error %.1f %%\n", name.c_str(),
                        n, seed, model.description.parts.size(), scene.parts.size(), verdict.types ? "right" : "WRONG",
                        100 * verdict.size_error);
        } catch (const std::exception& error) {
          std::snprintf(line, sizeof line, "%-18s %d views seed %d  FAILED: %.120s\n", name.c_str(), n, seed,
                        error.what());
        }
        std::printf("   %s", line);
        std::fflush(stdout);
        summary += line;
      }
    }
  }
  std::printf("\n%sparts and types right: %d of %d\n", summary.c_str(), right, runs);
  return 0;
}
