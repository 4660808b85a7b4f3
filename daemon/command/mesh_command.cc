// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "core/base/printed.h"
#include "core/surface/remesh.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {
namespace {

TriangleMesh ClosedMesh(const Input& input, const TessellateOptions& options, const CommandContext& context) {
  if (input.scan) {
    const std::vector<RangeView> views = ViewsOf(*input.scan, {}, context.stop, context.on_step).views;
    if (context.on_step) context.on_step("integrate", 0, 0);
    const PointCloud merged = IntegrateViews(views, {}, context.stop);
    if (context.on_step) context.on_step("tessellate", 0, 0);
    TessellateOptions with_table = options;
    with_table.close_on_table = options.close_on_table && input.scan->has_table;
    return Tessellate(views, merged, with_table, context.stop);
  }
  if (context.on_step) context.on_step("tessellate", 0, 0);
  if (input.is_mesh()) {
    const MeshTopology topology = Topology(input.file.mesh);
    if (topology.closed && topology.manifold) {
      RemeshOptions remesh;
      remesh.triangles = options.triangles;
      remesh.edge_length = options.edge_length;
      return Remesh(input.file.mesh, remesh, context.stop);
    }
    return TessellateCloud(PointsOf(input, context.stop, {}), options, context.stop);
  }
  return TessellateCloud(input.file.cloud, options, context.stop);
}

}  // namespace

CommandResult Mesh(const MeshArguments& arguments, const CommandContext& context) {
  const Stopwatch watch;
  const Input input = ReadInput(arguments.input, arguments.unit);
  TriangleMesh mesh;
  try {
    mesh = ClosedMesh(input, arguments.options, context);
  } catch (const std::invalid_argument& error) {
    throw FileError(input.name, "mesh", error.what());
  }
  GeometryFile file;
  file.mesh = mesh;
  WriteMesh(Scaled(std::move(file), 1.0 / arguments.unit).mesh, arguments.output);
  const MeshTopology topology = Topology(mesh);
  CommandResult result;
  result.json = {{"n_vertices", mesh.vertices.size()},
                 {"n_triangles", mesh.triangles.size()},
                 {"closed", topology.closed},
                 {"manifold", topology.manifold},
                 {"genus", topology.genus},
                 {"components", topology.components},
                 {"area_mm2", 1e6 * Area(mesh)},
                 {"volume_mm3", 1e9 * Volume(mesh)},
                 {"min_angle_deg", MinAngle(mesh) * 180.0 / std::numbers::pi},
                 {"seconds", watch.seconds()}};
  result.text = Printed("%s: %zu triangles, %s, genus %d, volume %.6g mm^3, smallest angle %.1f degrees",
                       arguments.output.c_str(), mesh.triangles.size(),
                       topology.closed && topology.manifold ? "closed and manifold"
                       : topology.closed                    ? "closed but not manifold"
                                                            : "not closed",
                       topology.genus, 1e9 * Volume(mesh), MinAngle(mesh) * 180.0 / std::numbers::pi);
  AddNotes(input, result);
  return result;
}

}  // namespace geond::daemon
