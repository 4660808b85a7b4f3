// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/geometry/mesh_files.h"
#include "sim/scene.h"
#include "sim/toml_reader.h"

namespace geond::sim {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kReach = 1000.0;  // mm: nothing larger or further away stands on a table

Eigen::Vector3d Vector(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

// position_mm, and rpy_deg (Rz Ry Rx) or axis with angle_deg.
Pose ReadPose(TomlReader& reader) {
  const Eigen::Vector3d position = kMillimetre * Vector(reader.Numbers("position_mm", 3, {{0, 0, 0}}, -kReach, kReach));
  const bool about_axis = reader.Has("axis") || reader.Has("angle_deg");
  if (about_axis && reader.Has("rpy_deg"))
    reader.Fail("rpy_deg", "stands beside axis and angle_deg", "Give one of the two");
  if (about_axis) {
    const Eigen::Vector3d axis = Vector(reader.Numbers("axis", 3, {}));
    if (!(axis.norm() > 1e-9)) reader.Fail("axis", "has no length");
    return Pose::Translation(position) * Pose::Rotation(axis, kDegree * reader.Number("angle_deg", {}, -360, 360));
  }
  const Eigen::Vector3d rpy = kDegree * Vector(reader.Numbers("rpy_deg", 3, {{0, 0, 0}}, -360, 360));
  return Pose::Translation(position) * Pose::Rotation(Eigen::Vector3d::UnitZ(), rpy.z()) *
         Pose::Rotation(Eigen::Vector3d::UnitY(), rpy.y()) * Pose::Rotation(Eigen::Vector3d::UnitX(), rpy.x());
}

Scene::Part ReadPart(TomlReader& reader) {
  Scene::Part part;
  part.name = reader.Text("name", "");
  const std::string type = reader.Text("type", {});
  try {
    part.geon.type = GeonTypeFromName(type);
  } catch (const std::invalid_argument&) {
    std::string names;
    for (const GeonType known : kGeonTypes) names += (names.empty() ? "" : ", ") + std::string(GeonTypeName(known));
    reader.Fail("type", "\"" + type + "\" is no geon", "Known are: " + names);
  }
  part.geon.size = kMillimetre * Vector(reader.Numbers("size_mm", 3, {}, 0.1, kReach));
  const std::vector<double> taper = reader.Numbers("taper", 2, {{0, 0}}, 0.0, 0.95);
  part.geon.taper = {taper[0], taper[1]};
  if (reader.Has("taper") && !IsTapered(part.geon.type)) reader.Fail("taper", "belongs to tapered types only");
  part.geon.bend = reader.Number("bend_per_mm", 0.0, 0.0, 1.0) / kMillimetre;
  if (reader.Has("bend_per_mm") && !IsCurved(part.geon.type))
    reader.Fail("bend_per_mm", "belongs to curved types only");
  part.geon.X_TG = ReadPose(reader);
  try {
    GeonSurface check(part.geon);
  } catch (const std::invalid_argument& error) {
    reader.Fail("", error.what());
  }
  reader.Finish();
  return part;
}

Scene::Body ReadBody(TomlReader& reader, const std::filesystem::path& folder) {
  Scene::Body body;
  body.name = reader.Text("name", "");
  const std::string file = reader.Text("file", {});
  const double scale = reader.Number("scale_mm", 1.0, 1e-6, 1e6);  // mm a unit of the file
  const Pose X_TB = ReadPose(reader);
  reader.Finish();
  GeometryFile geometry = ReadGeometry(folder / file);
  if (!geometry.has_faces())
    reader.Fail("file", file + " has points but no faces, so no ray can meet it", "Mesh it first");
  TriangleMesh mesh = std::move(geometry.mesh);
  for (Eigen::Vector3d& p : mesh.vertices) p *= scale * kMillimetre;
  body.mesh = Transform(X_TB, mesh);
  for (const auto& t : body.mesh.triangles) {
    for (const int v : t) {
      if (!(body.mesh.vertices[v].norm() < 2 * kReach * kMillimetre)) {
        reader.Fail("scale_mm", "makes the mesh larger than any turntable",
                    "Give the millimetres of one unit of the file");
      }
    }
  }
  return body;
}

// Raises or lowers the whole object until its lowest point is on the table.
void RestOnTable(Scene& scene) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Scene::Part& part : scene.parts) lowest = std::min(lowest, GeonSurface(part.geon).lowest_z());
  for (const Scene::Body& body : scene.bodies) {
    for (const auto& t : body.mesh.triangles) {
      for (const int v : t) lowest = std::min(lowest, body.mesh.vertices[v].z());
    }
  }
  const Pose lift = Pose::Translation({0, 0, -lowest});
  for (Scene::Part& part : scene.parts) part.geon.X_TG = lift * part.geon.X_TG;
  for (Scene::Body& body : scene.bodies) body.mesh = Transform(lift, body.mesh);
}

Scene ReadSceneTable(const toml::table& root, const std::filesystem::path& path) {
  TomlReader reader(root, path, "");
  Scene scene;
  scene.name = reader.Text("name", path.stem().string());
  reader.Text("description", "");
  const bool rest = reader.Flag("rest_on_table", true);
  scene.table_radius = kMillimetre * reader.Number("table_radius_mm", 200.0, 0.0, kReach);
  scene.wall_distance = kMillimetre * reader.Number("wall_distance_mm", 600.0, 0.0, 10 * kReach);
  for (TomlReader& part : reader.Tables("geon")) scene.parts.push_back(ReadPart(part));
  for (TomlReader& body : reader.Tables("mesh")) scene.bodies.push_back(ReadBody(body, path.parent_path()));
  reader.Finish();
  if (scene.parts.empty() && scene.bodies.empty()) {
    reader.Fail("", "there is no object", "Add a table [[geon]] or [[mesh]]");
  }
  if (rest) RestOnTable(scene);
  return scene;
}

}  // namespace

Scene ReadScene(const std::filesystem::path& path) { return ReadSceneTable(ReadToml(path), path); }

Scene ParseScene(const std::string& text, const std::filesystem::path& folder) {
  return ReadSceneTable(ParseToml(text, "the scene"), folder / "scene");
}

}  // namespace geond::sim
