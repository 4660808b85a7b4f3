// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/picture/color.h"

namespace geond {

// How a mesh looks.
struct MeshStyle {
  Color color{0.74f, 0.76f, 0.80f};
  std::vector<Color> triangle_colors;  // one a triangle, or empty
  std::vector<Color> vertex_colors;    // one a vertex (used if there are none a triangle), or empty
  double crease_angle = 0.6;           // rad: edges bent more than that stay sharp, others look smooth; 0: all sharp
  double opacity = 1.0;                // below 1: what lies behind shines through
  bool outline = true;                 // a thin dark line where the surface ends
};

// How points look: discs along the surface if there are normals, else balls.
struct CloudStyle {
  Color color{0.30f, 0.42f, 0.58f};
  std::vector<Color> point_colors;  // one a point, or empty
  double radius = 0.0;              // m; 0: from how far the points lie apart
  double opacity = 1.0;
};

struct LineStyle {
  Color color{0.15f, 0.15f, 0.18f};
  double width = 1.2;  // pixels
};

struct Segment {
  Eigen::Vector3d from, to;
};

// What a picture shows; lengths in m, z up.
struct Scene {
  struct Mesh {
    TriangleMesh mesh;
    MeshStyle style;
  };
  struct Cloud {
    PointCloud cloud;
    CloudStyle style;
  };
  struct Lines {
    std::vector<Segment> segments;
    LineStyle style;
  };
  struct Label {
    Eigen::Vector3d at;
    std::string text;
    Color color;
  };
  std::vector<Mesh> meshes;
  std::vector<Cloud> clouds;
  std::vector<Lines> lines;
  std::vector<Label> labels;  // drawn over everything, the text's middle at the point

  void Add(TriangleMesh mesh, MeshStyle style = {}) { meshes.push_back({std::move(mesh), std::move(style)}); }
  void Add(PointCloud cloud, CloudStyle style = {}) { clouds.push_back({std::move(cloud), std::move(style)}); }
  void Add(std::vector<Segment> segments, LineStyle style = {}) { lines.push_back({std::move(segments), style}); }
  void AddLabel(const Eigen::Vector3d& at, std::string text, const Color& color = Color::Constant(0.1f)) {
    labels.push_back({at, std::move(text), color});
  }
};

// Edges of the mesh where the surface bends by more than `angle` (rad) or ends.
std::vector<Segment> CreaseSegments(const TriangleMesh& mesh, double angle = 0.6);
// Edges between triangles of different labels.
std::vector<Segment> BorderSegments(const TriangleMesh& mesh, const std::vector<int>& labels);
// Every edge once.
std::vector<Segment> WireSegments(const TriangleMesh& mesh);

// Where a scene is looked at from, in perspective.
struct Camera {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  // m: drawn in the middle
  double azimuth = 0.6;         // rad: where the eye is, from +x counter-clockwise seen from above, ...
  double elevation = 0.4;       // rad: ... and above the horizon
  double distance = 1.0;        // m: eye to target
  double field_of_view = 0.35;  // rad: of the shorter side of the picture
};

// The camera at that azimuth and elevation from which everything of the scenes fills a picture of aspect = columns /
// rows, less `margin` of its size. Throws std::invalid_argument if there is nothing in them.
Camera Framing(const std::vector<const Scene*>& scenes, double azimuth, double elevation, double aspect,
               double margin = 0.05);

}  // namespace geond
