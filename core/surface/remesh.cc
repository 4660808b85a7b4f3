// SPDX-License-Identifier: Apache-2.0
// Isotropic remeshing after Botsch and Kobbelt (A remeshing approach to multiresolution modeling, 2004).
#include "core/surface/remesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/geometry/point_cloud.h"
#include "core/surface/remesher.h"
#include "core/surface/triangle_tree.h"

namespace geond {
namespace {

constexpr double kSliver = 0.42;  // rad: triangles with a smaller angle are taken out where that can be

// The side of the even triangles of which `triangles` cover `area`.
double EvenEdge(double area, int triangles) {
  return std::sqrt(4.0 * area / (std::numbers::sqrt3 * triangles));
}

TriangleMesh Run(Remesher& remesher, const RemeshOptions& options, const SurfaceProjection& on_surface,
                 const SurfaceProjection& on_crease, const std::stop_token& stop) {
  const int iterations = std::max(1, options.iterations);
  for (int i = 0; i < iterations; ++i) {
    ThrowIfStopped(stop);
    remesher.SplitLongEdges();
    ThrowIfStopped(stop);
    remesher.CollapseShortEdges(i > 0);
    remesher.FlipToValence();
    remesher.Relax(on_surface, on_crease);
    if (options.edge_length <= 0.0 && i + 2 < iterations) {
      const double excess = static_cast<double>(remesher.CountTriangles()) / options.triangles;
      remesher.SetEdgeLength(remesher.edge_length() * std::clamp(std::sqrt(excess), 0.7, 1.4));
    }
  }
  for (int i = 0; i < 3; ++i) {
    ThrowIfStopped(stop);
    remesher.FlipToAngle();
    remesher.CollapseSlivers(kSliver);
    remesher.Relax(on_surface, on_crease);
  }
  remesher.FlipToAngle();
  return remesher.mesh().ToMesh();
}

void CheckOptions(const RemeshOptions& options) {
  if (!(options.edge_length > 0.0) && options.triangles < 4) {
    throw std::invalid_argument("Remesh: give an edge length above 0 or at least 4 triangles");
  }
}

double WantedEdge(const TriangleMesh& mesh, const RemeshOptions& options) {
  const double edge = options.edge_length > 0.0 ? options.edge_length : EvenEdge(Area(mesh), options.triangles);
  if (!(edge > 0.0) || !std::isfinite(edge)) throw std::invalid_argument("Remesh: the mesh has no area");
  const double count = 4.0 * Area(mesh) / (std::numbers::sqrt3 * edge * edge);
  if (count > 2e7) {
    throw std::invalid_argument("Remesh: edges of " + std::to_string(edge * 1e3) + " mm would take over 20 million triangles");
  }
  return edge;
}

}  // namespace

TriangleMesh RemeshOnto(const TriangleMesh& mesh, const SurfaceProjection& project, const RemeshOptions& options,
                        std::stop_token stop) {
  CheckOptions(options);
  Remesher remesher(HalfEdgeMesh(mesh), WantedEdge(mesh, options), options.threads);
  return Run(remesher, options, project, project, stop);
}

TriangleMesh RelaxOnto(const TriangleMesh& mesh, const SurfaceProjection& project, int rounds, int threads,
                       std::stop_token stop) {
  Remesher remesher(HalfEdgeMesh(mesh), MeanEdgeLength(mesh), threads);
  for (int i = 0; i < rounds; ++i) {
    ThrowIfStopped(stop);
    remesher.FlipToAngle();
    remesher.CollapseSlivers(kSliver);
    remesher.Relax(project, project);
  }
  remesher.FlipToAngle();
  return remesher.mesh().ToMesh();
}

namespace {

// A mesh in units of its own box, about its middle, rounded to 2^-28 of that: the same shape in metres and in millimetres is
// then the same to the bit, and so is what is made of it, though ties between edges hang on the last bit.
struct OwnUnits {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double size = 1.0;  // m

  explicit OwnUnits(const TriangleMesh& mesh) {
    const Eigen::AlignedBox3d box = BoundingBox(mesh.vertices);
    center = box.center();
    size = box.diagonal().norm();
    if (!(size > 0.0) || !std::isfinite(size)) throw std::invalid_argument("Remesh: the mesh has no area");
  }
  TriangleMesh From(TriangleMesh mesh) const {
    constexpr double kSteps = 0x1p28;
    for (Eigen::Vector3d& p : mesh.vertices) p = (((p - center) / size) * kSteps).array().round().matrix() / kSteps;
    return mesh;
  }
  TriangleMesh Back(TriangleMesh mesh) const {
    for (Eigen::Vector3d& p : mesh.vertices) p = center + size * p;
    return mesh;
  }
};

}  // namespace

TriangleMesh Remesh(const TriangleMesh& mesh_in, const RemeshOptions& options_in, std::stop_token stop) {
  CheckOptions(options_in);
  WantedEdge(mesh_in, options_in);
  const OwnUnits units(mesh_in);
  const TriangleMesh mesh = units.From(mesh_in);
  RemeshOptions options = options_in;
  options.edge_length = options_in.edge_length / units.size;
  Remesher remesher(HalfEdgeMesh(mesh), WantedEdge(mesh, options), options.threads);
  remesher.MarkCreases(options.crease_angle);

  const TriangleTree tree(mesh.vertices, mesh.triangles);
  const std::vector<Eigen::Vector3d> normals = TriangleNormals(mesh);
  std::vector<std::array<int, 3>> segments;
  for (int h = 0; h < remesher.mesh().n_half_edges(); ++h) {
    const int from = remesher.mesh().origin[h], to = remesher.mesh().target(h);
    if (remesher.mesh().crease[h] && h < remesher.mesh().twin[h]) segments.push_back({from, to, to});
  }
  const TriangleTree creases(mesh.vertices, segments);

  // The other face of a thin wall may be nearer: then the point stays where it is.
  const auto on_surface = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& normal) -> Eigen::Vector3d {
    const TriangleTree::Hit hit = tree.Nearest(p);
    return normals[hit.triangle].dot(normal) >= -0.2 ? hit.point : p;
  };
  const auto on_crease = [&](const Eigen::Vector3d& p, const Eigen::Vector3d&) -> Eigen::Vector3d {
    return creases.empty() ? p : creases.Nearest(p).point;
  };
  TriangleMesh result = Run(remesher, options, on_surface, on_crease, stop);

  if (mesh.triangle_seen.size() == mesh.triangles.size()) {
    result.triangle_seen.resize(result.triangles.size());
    ParallelFor(static_cast<std::ptrdiff_t>(result.triangles.size()), options.threads, 256, [&](std::ptrdiff_t t) {
      result.triangle_seen[t] = mesh.triangle_seen[tree.Nearest(TriangleCentroid(result, static_cast<int>(t))).triangle];
    });
  }
  return units.Back(std::move(result));
}

}  // namespace geond
