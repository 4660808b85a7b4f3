// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/geon/geon.h"
#include "sim/bvh.h"
#include "sim/geon_surface.h"

namespace geond::sim {

// What stands on the turntable, in T (m). Geons and meshes may run into each other: the object is their union.
struct Scene {
  struct Part {
    std::string name;
    Geon geon;  // X_TG
  };
  struct Body {
    std::string name;
    TriangleMesh mesh;  // in T
  };
  std::string name;
  std::vector<Part> parts;
  std::vector<Body> bodies;
  double table_radius = 0.200;   // m, of the disc at z = 0; 0: no table
  double wall_distance = 0.600;  // m from the axis, behind the object as the sensor looks; 0: no wall
};

// Reads a scene (TOML; config/scenes/ has samples). Paths of meshes are relative to the file. Throws FileError if it is
// absent, ConfigError naming file, line and key if it says what cannot be.
Scene ReadScene(const std::filesystem::path& path);
// The same from text; paths of meshes are relative to `folder`.
Scene ParseScene(const std::string& text, const std::filesystem::path& folder);

// The true description as JSON text: parts with type, half sizes, taper, bend and pose in T, as `geon describe` names
// them.
std::string TruthJson(const Scene& scene);

// A scene made ready for rays; read by any thread.
class SceneGeometry {
 public:
  // Throws std::invalid_argument if a geon or mesh is impossible.
  explicit SceneGeometry(const Scene& scene);

  enum class Surface { kNothing, kObject, kTable, kWall };
  struct Hit {
    double t = std::numeric_limits<double>::infinity();  // m along the ray
    Surface surface = Surface::kNothing;
    int item = -1;               // of the object: index of the part, then of the bodies
    double cos_incidence = 0.0;  // of normal and line of sight, 0 to 1
  };
  // The first thing a ray in T meets. `wall_direction_T`: unit and horizontal, from the sensor to the wall, or zero.
  Hit Cast(const Ray& ray, const Eigen::Vector3d& wall_direction_T) const;

  // Of the object, in T.
  const Eigen::AlignedBox3d& box() const { return box_; }

 private:
  std::vector<GeonSurface> surfaces_;
  std::vector<std::vector<Eigen::Vector3d>> body_normals_;
  std::vector<int> first_triangle_;  // of each body, in the numbering of the tree's items
  double table_radius_, wall_distance_;
  Eigen::AlignedBox3d box_;
  Bvh tree_;
};

}  // namespace geond::sim
