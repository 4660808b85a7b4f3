// SPDX-License-Identifier: Apache-2.0
// Closed meshes of simulated scans against the true surface: surface_cases_validation FOLDER [-t TRIANGLES] [-e EDGE_MM]
// [-o OUTPUT_FOLDER] [NAME...]. FOLDER holds one folder a case.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <set>

#include "core/geometry/mesh_files.h"
#include "core/surface/integrate.h"
#include "core/surface/tessellate.h"
#include "tests/validation/surface_case.h"

int main(int argc, char** argv) {
  using namespace geond;
  if (argc < 2) return std::fprintf(stderr, "usage: %s FOLDER [-t TRIANGLES] [-e EDGE_MM] [-o OUT] [NAME...]\n", argv[0]), 2;
  TessellateOptions options{.triangles = 11000};
  std::string out;
  std::set<std::string> wanted;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "-t" && i + 1 < argc) options.triangles = std::atoi(argv[++i]);
    else if (argument == "-e" && i + 1 < argc) options.edge_length = 1e-3 * std::atof(argv[++i]);
    else if (argument == "-o" && i + 1 < argc) out = argv[++i];
    else wanted.insert(argument);
  }
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) {
    if (wanted.empty() || wanted.contains(entry.path().filename().string())) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  std::printf("%-16s %6s %6s %4s %5s | %6s %6s %6s | %4s %4s %4s | %4s %4s %4s %6s | %5s %5s %5s | %5s %5s %5s\n", "case", "merged", "tris",
              "edge", "ok", "seen", "unseen", "worst", "1mm", "2mm", "3mm", "cvx1", "cvx2", "cvx3", "crease", "min", "1%", "area", "share", "wall", "cpu");
  double seen = 0, unseen = 0;
  int n = 0;
  for (const auto& folder : folders) {
    const SurfaceCase surface = ReadSurfaceCase(folder);
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    const PointCloud merged = IntegrateViews(surface.views);
    const TriangleMesh mesh = Tessellate(surface.views, merged, options);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    const SurfaceFigures f = Measure(mesh, surface);
    const bool ok = f.topology.closed && f.topology.manifold && f.topology.components == 1 && f.topology.genus == surface.genus;
    std::printf("%-16s %6zu %6zu %4.2f %5s | %6.3f %6.3f %6.3f | %4.2f %4.2f %4.2f | %4.2f %4.2f %4.2f %6.3f | %5.1f %5.1f %5.2f | %5.2f %5.2f %5.2f\n",
                surface.name.c_str(), merged.size(), mesh.triangles.size(), 1e3 * MeanEdgeLength(mesh),
                ok ? "ok" : ("g" + std::to_string(f.topology.genus) + "c" + std::to_string(f.topology.components)).c_str(), f.rms_seen,
                f.rms_unseen, f.worst_seen, f.contrast[0], f.contrast[1], f.contrast[2], f.convex[0], f.convex[1], f.convex[2],
                f.crease_rms, f.min_angle, f.min_angle_1, f.area_ratio, f.seen_share, seconds, cpu_seconds);
    std::fflush(stdout);
    if (!out.empty()) WriteMesh(mesh, std::filesystem::path(out) / (surface.name + ".ply"));
    seen += f.rms_seen;
    unseen += f.rms_unseen;
    ++n;
  }
  if (n > 0) std::printf("mean rms, mm: seen %.3f unseen %.3f\n", seen / n, unseen / n);
}
