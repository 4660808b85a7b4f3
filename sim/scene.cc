// SPDX-License-Identifier: Apache-2.0
#include "sim/scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace geond::sim {

SceneGeometry::SceneGeometry(const Scene& scene)
    : table_radius_(scene.table_radius), wall_distance_(scene.wall_distance) {
  std::vector<Bvh::Triangle> triangles;
  for (const Scene::Part& part : scene.parts) {
    const int item = static_cast<int>(surfaces_.size());
    surfaces_.emplace_back(part.geon);
    const TriangleMesh& shell = surfaces_.back().shell();
    for (const auto& t : shell.triangles) {
      triangles.push_back({shell.vertices[t[0]], shell.vertices[t[1]], shell.vertices[t[2]], item});
    }
    box_.extend(BoundingBox(shell.vertices));
  }
  int next_item = static_cast<int>(surfaces_.size());
  for (const Scene::Body& body : scene.bodies) {
    CheckMesh(body.mesh);
    first_triangle_.push_back(next_item);
    body_normals_.push_back(TriangleNormals(body.mesh));
    for (const auto& t : body.mesh.triangles) {
      triangles.push_back({body.mesh.vertices[t[0]], body.mesh.vertices[t[1]], body.mesh.vertices[t[2]], next_item++});
      for (const int v : t) box_.extend(body.mesh.vertices[v]);
    }
  }
  tree_ = Bvh(std::move(triangles));
}

SceneGeometry::Hit SceneGeometry::Cast(const Ray& ray, const Eigen::Vector3d& wall_direction_T) const {
  Hit hit;
  int item = -1;
  const int geons = static_cast<int>(surfaces_.size());
  tree_.Visit(ray, hit.t, [&](int candidate, double t, bool front) {
    if (candidate >= geons) {
      hit.t = t;
      item = candidate;
    } else if (front) {
      const auto met = surfaces_[candidate].Meet(ray.origin, ray.direction, t);
      if (met && *met < hit.t) {
        hit.t = *met;
        item = candidate;
      }
    }
    return hit.t;
  });
  if (item >= 0) {
    hit.surface = Surface::kObject;
    Eigen::Vector3d normal;
    if (item < geons) {
      hit.item = item;
      normal = surfaces_[item].At(ray.origin + hit.t * ray.direction).gradient.normalized();
    } else {
      const auto body =
          std::upper_bound(first_triangle_.begin(), first_triangle_.end(), item) - first_triangle_.begin() - 1;
      hit.item = geons + static_cast<int>(body);
      normal = body_normals_[body][item - first_triangle_[body]];
    }
    hit.cos_incidence = std::min(1.0, std::abs(normal.dot(ray.direction)));
  }
  if (table_radius_ > 0.0 && ray.direction.z() < 0.0) {
    const double t = -ray.origin.z() / ray.direction.z();
    if (t > 0.0 && t < hit.t && (ray.origin + t * ray.direction).head<2>().norm() <= table_radius_) {
      hit = {t, Surface::kTable, -1, -ray.direction.z()};
    }
  }
  const double towards_wall = wall_direction_T.dot(ray.direction);
  if (wall_distance_ > 0.0 && towards_wall > 0.0) {
    const double t = (wall_distance_ - wall_direction_T.dot(ray.origin)) / towards_wall;
    if (t > 0.0 && t < hit.t) hit = {t, Surface::kWall, -1, towards_wall};
  }
  return hit;
}

std::string TruthJson(const Scene& scene) {
  using nlohmann::ordered_json;
  const auto rounded = [](double value) { return std::round(value * 1e9) / 1e9; };
  ordered_json truth;
  truth["name"] = scene.name;
  truth["n_parts"] = scene.parts.size() + scene.bodies.size();
  truth["sizes_are"] = "half sizes along x, y, z of the geon";
  truth["parts"] = ordered_json::array();
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    const Geon& geon = scene.parts[i].geon;
    const Eigen::Vector3d& p = geon.X_TG.translation();
    const Eigen::Quaterniond& q = geon.X_TG.rotation();
    ordered_json part;
    part["id"] = i + 1;
    part["name"] = scene.parts[i].name;
    part["type"] = GeonTypeName(geon.type);
    part["type_index"] = static_cast<int>(geon.type);
    part["pose"]["position_mm"] = {rounded(1e3 * p.x()), rounded(1e3 * p.y()), rounded(1e3 * p.z())};
    part["pose"]["quaternion"] = {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}};
    part["size_mm"] = {rounded(1e3 * geon.size.x()), rounded(1e3 * geon.size.y()), rounded(1e3 * geon.size.z())};
    part["taper"] = {geon.taper.x(), geon.taper.y()};
    part["bend_per_mm"] = rounded(1e-3 * geon.bend);
    truth["parts"].push_back(part);
  }
  truth["meshes"] = ordered_json::array();
  for (const Scene::Body& body : scene.bodies) {
    truth["meshes"].push_back({{"name", body.name}, {"volume_mm3", 1e9 * Volume(body.mesh)}});
  }
  return truth.dump();
}

}  // namespace geond::sim
