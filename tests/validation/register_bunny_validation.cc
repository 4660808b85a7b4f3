// SPDX-License-Identifier: Apache-2.0
// The bunny's ten raw range scans from perturbed poses: register_bunny_validation FOLDER [degrees mm]. The poses of bun.conf
// are what the published surface was made with; the closed mesh at the poses found is compared with that surface.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numeric>
#include <string>

#include <Eigen/Geometry>

#include "calib/conf_scan.h"
#include "calib/make_view.h"
#include "calib/pair_terms.h"
#include "calib/pose_model.h"
#include "calib/register_views.h"
#include "core/geometry/mesh_files.h"
#include "core/surface/integrate.h"
#include "core/surface/tessellate.h"
#include "core/surface/triangle_tree.h"
#include "tests/calib/registration_case.h"
#include "tests/calib/synthetic_scan.h"

using namespace geond;
using namespace geond::calib;

namespace {

// The motion that carries points by the one poses onto those by the others best.
Eigen::Isometry3d CommonMotion(const std::vector<RangeView>& views, const std::vector<Pose>& from, const std::vector<Pose>& to) {
  std::vector<Eigen::Vector3d> p, q;
  for (std::size_t k = 0; k < views.size(); ++k) {
    for (const auto& point_S : ViewCloud(views[k]).points) p.push_back(from[k] * point_S), q.push_back(to[k] * point_S);
  }
  const Eigen::Map<const Eigen::Matrix3Xd> P(p[0].data(), 3, static_cast<Eigen::Index>(p.size()));
  const Eigen::Map<const Eigen::Matrix3Xd> Q(q[0].data(), 3, static_cast<Eigen::Index>(q.size()));
  return Eigen::Isometry3d(Eigen::umeyama(P, Q, false));
}

// The closed mesh of the views at these poses against the published surface (vertices in the frame of `published`, m).
void CompareWithPublished(std::vector<RangeView> views, const std::vector<Pose>& found, const std::vector<Pose>& published,
                          const std::vector<Eigen::Vector3d>& surface) {
  for (std::size_t k = 0; k < views.size(); ++k) views[k].X_TS = found[k];
  const std::clock_t clock = std::clock();
  TessellateOptions options{.triangles = 70000};
  options.close_on_table = false;
  const TriangleMesh mesh = Tessellate(views, IntegrateViews(views), options);
  const double seconds = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
  const TriangleTree tree(mesh.vertices, mesh.triangles);
  const Eigen::Isometry3d back = CommonMotion(views, published, found);
  std::vector<double> squares;
  for (const auto& p : surface) squares.push_back(tree.Nearest(back * p).squared_distance);
  std::ranges::sort(squares);
  const double rms = std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size()));
  const MeshTopology topology = Topology(mesh);
  std::printf("      mesh: %zu triangles, %s, %s, %d piece%s, %.1f cpu s; %zu published vertices: rms %.3f mm, 99 %% within %.3f mm\n",
              mesh.triangles.size(), topology.closed ? "closed" : "OPEN", topology.manifold ? "manifold" : "NOT MANIFOLD",
              topology.components, topology.components == 1 ? "" : "s", seconds, surface.size(), 1e3 * rms,
              1e3 * std::sqrt(squares[squares.size() * 99 / 100]));
}

}  // namespace

int main(int argc, char** argv) {
  const std::filesystem::path folder =
      argc > 1 ? argv[1] : std::string(GEOND_SOURCE_DIR) + "/../shared/data/stanford_bunny_range";
  const double degrees = argc > 2 ? std::atof(argv[2]) : 2.0, millimetres = argc > 3 ? std::atof(argv[3]) : 5.0;
  const auto views = MakeViews(ReadConfScan(folder / "bun.conf"));
  std::vector<Pose> published;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double n = 0;
  for (const auto& view : views) {
    published.push_back(view.X_TS);
    const PointCloud cloud = Transform(view.X_TS, ViewCloud(view));
    for (const auto& p : cloud.points) middle += p, n += 1;
  }
  middle /= n;
  std::printf("%zu views, %.0f points\n%5s %9s %9s %9s | %9s %9s %9s %7s\n", views.size(), n, "seed", "start mm",
              "displ mm", "shape mm", "rms start", "rms end", "published", "cpu s");
  const std::vector<Eigen::Vector3d> surface = ReadGeometry(folder / "bun_zipper_res2.ply").cloud.points;
  RegisterOptions keep;
  keep.model = RegisterOptions::Model::kNone;
  const double published_rms = RegisterViews(views, keep).rms_after;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Noise random(seed);
    std::vector<Pose> start;
    for (const auto& X : published) {
      Vector6d motion;
      motion << degrees * M_PI / 180 * random.Vector().normalized(), 1e-3 * millimetres * random.Vector().normalized();
      start.push_back(Moved(X, motion, middle, 1.0));
    }
    RegisterOptions options;
    options.model = RegisterOptions::Model::kFree;
    options.prior_rotation = degrees * M_PI / 180;
    options.prior_translation = 1e-3 * millimetres;
    options.max_distance = 0.015;
    options.rounds = 20;
    const std::clock_t clock = std::clock();
    const auto result = RegisterViews(StartingAt(views, start), options);
    const double seconds = static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC;
    const auto before = ComparePoses(views, start, published), after = ComparePoses(views, result.X_TS, published);
    std::printf("%5d %9.3f %9.3f %9.3f | %9.3f %9.3f %9.3f %7.2f\n", static_cast<int>(seed), before.displacement_rms * 1e3,
                after.displacement_rms * 1e3, after.shape_rms * 1e3, result.rms_before * 1e3, result.rms_after * 1e3,
                published_rms * 1e3, seconds);
    for (const auto& note : result.notes) std::printf("      %s\n", note.c_str());
    CompareWithPublished(views, result.X_TS, published, surface);
  }
}
