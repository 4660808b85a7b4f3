// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/point_cloud.h"
#include "core/geometry/triangle_mesh.h"
#include "core/picture/image.h"

namespace geond {

// What is known of an object, as far as it is known; lengths in m, z up.
struct ObjectPictureData {
  PointCloud cloud;
  TriangleMesh mesh;
  std::vector<double> charge;  // density, one a triangle of the mesh, or empty
  std::vector<int> labels;     // part of each triangle (from 0; -1 none), or empty
  struct Geon {
    TriangleMesh surface;
    std::string label;  // such as "tapered cylinder 81 x 80 x 122 mm"
  };
  std::vector<Geon> geons;  // a part each, in the order of the labels
  std::string title;
};

enum class Panel { kCloud, kMesh, kCharge, kParts, kGeons };

struct ObjectPictureOptions {
  std::vector<Panel> panels;  // side by side; empty: all for which there is something to show
  int columns = 1600;         // of the whole picture
  int rows = 0;               // 0: what suits the panels
  double azimuth = 0.6;       // rad: where the eye is, from +x counter-clockwise, ...
  double elevation = 0.35;    // rad: ... and above the horizon
  int samples = 2;            // a side of a pixel, 1 to 4: smooth edges
  int threads = 0;
};

// "cloud", "mesh", "charge", "parts", "geons". Throws std::invalid_argument, naming them, for any other word.
Panel PanelFromName(std::string_view name);

// The object panel by panel, from one point of view: its points; the mesh; the mesh by charge (blue less than the mean,
// red more); by part; the fitted geons over the points. With headings, scale bar and legends. Throws
// std::invalid_argument if there is nothing to show, or lists and mesh do not agree.
Image ObjectPicture(const ObjectPictureData& data, const ObjectPictureOptions& options = {});

}  // namespace geond
