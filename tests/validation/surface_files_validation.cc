// SPDX-License-Identifier: Apache-2.0
// Closed meshes of clouds and meshes from elsewhere: surface_files_validation [-t TRIANGLES] [-o OUTPUT_FOLDER] FILE...
// Lengths in the files' own unit. A mesh that is closed and manifold is remeshed, another one closed.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/mesh_files.h"
#include "core/geometry/point_cloud.h"
#include "core/surface/close_mesh.h"
#include "core/surface/remesh.h"
#include "core/surface/tessellate.h"
#include "core/surface/triangle_tree.h"

int main(int argc, char** argv) {
  using namespace geond;
  TessellateOptions options;
  std::filesystem::path out;
  std::vector<std::filesystem::path> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "-t" && i + 1 < argc) options.triangles = std::atoi(argv[++i]);
    else if (argument == "-o" && i + 1 < argc) out = argv[++i];
    else files.emplace_back(argument);
  }
  std::printf("%-24s %8s %8s %6s | %6s %5s %5s %5s %5s %6s | %6s %6s\n", "file", "points", "faces", "way", "tris", "comp", "genus", "seen",
              "angle", "rms%", "wall", "cpu");
  for (const auto& path : files) {
    try {
      const GeometryFile file = Scaled(ReadGeometry(path), 1e-3);
      const auto start = std::chrono::steady_clock::now();
      const std::clock_t cpu = std::clock();
      const char* way = "cloud";
      TriangleMesh mesh;
      try {
        if (file.has_faces()) {
          const MeshTopology topology = Topology(file.mesh);
          const bool whole = topology.closed && topology.manifold;
          way = whole ? "remesh" : "close";
          mesh = whole ? Remesh(file.mesh, {.triangles = options.triangles}) : CloseMesh(file.mesh, options);
        } else {
          mesh = TessellateCloud(file.cloud, options);
        }
      } catch (const std::invalid_argument& error) {
        std::printf("%-24s %8zu %8zu %6s | %s (%.1f s)\n", path.filename().c_str(), file.cloud.size(), file.mesh.triangles.size(), way, error.what(),
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        std::fflush(stdout);
        continue;
      }
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      const double cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
      const MeshTopology topology = Topology(mesh);
      const TriangleTree tree(mesh.vertices, mesh.triangles);
      double squares = 0.0, seen = 0.0;
      for (const Eigen::Vector3d& p : file.cloud.points) squares += tree.Nearest(p).squared_distance;
      for (std::uint8_t s : mesh.triangle_seen) seen += s;
      const double diagonal = BoundingBox(file.cloud.points).diagonal().norm();
      std::printf("%-24s %8zu %8zu %6s | %6zu %5d %5d %5.2f %5.1f %6.3f | %6.2f %6.2f%s\n", path.filename().c_str(), file.cloud.size(),
                  file.mesh.triangles.size(), way, mesh.triangles.size(), topology.components, topology.genus,
                  seen / static_cast<double>(mesh.triangles.size()), MinAngle(mesh) * 57.29578,
                  100.0 * std::sqrt(squares / static_cast<double>(file.cloud.size())) / diagonal, seconds, cpu_seconds,
                  topology.closed && topology.manifold ? "" : "  NOT A CLOSED MANIFOLD");
      if (!out.empty()) WriteMesh(mesh, out / (path.stem().string() + ".ply"));
    } catch (const std::exception& error) {
      std::printf("%-24s %s\n", path.filename().c_str(), error.what());
    }
    std::fflush(stdout);
  }
}
