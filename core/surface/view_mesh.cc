// SPDX-License-Identifier: Apache-2.0
// Thesis App. C with its corrections: the second triangle of a full window is (i+1, j), (i+1, j+1), (i, j+1); the window
// without its top left pixel is looked at too; edges over a depth jump are not spanned. The bottom is projected along the
// lines of sight, which is the thesis' projection for parallel rays and cannot fold for others.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/surface/tessellate.h"

namespace geond {
namespace {

// Depths of every step-th pixel of the object, NaN elsewhere; lone gaps inside are filled from their surroundings.
RangeImage ObjectDepths(const RangeView& view, int step, double jump) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  RangeImage image;
  image.columns = (view.image.columns + step - 1) / step;
  image.rows = (view.image.rows + step - 1) / step;
  image.depth.assign(static_cast<std::size_t>(image.columns) * image.rows, kNan);
  std::vector<bool> may_fill(image.depth.size(), false);
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.columns; ++c) {
      const std::size_t pixel = view.image.index(c * step, r * step);
      if (view.IsObject(pixel)) image.depth[image.index(c, r)] = view.image.depth[pixel];
      may_fill[image.index(c, r)] = view.classes[pixel] == PixelClass::kNothing || view.classes[pixel] == PixelClass::kRejected;
    }
  }
  for (int pass = 0; pass < 2; ++pass) {
    const RangeImage before = image;
    for (int r = 1; r + 1 < image.rows; ++r) {
      for (int c = 1; c + 1 < image.columns; ++c) {
        if (std::isfinite(before.at(c, r)) || !may_fill[image.index(c, r)]) continue;
        double sum = 0.0, low = 1e300, high = -1e300;
        int n = 0;
        for (int k = 0; k < 9; ++k) {
          const float z = before.at(c + k % 3 - 1, r + k / 3 - 1);
          if (!std::isfinite(z)) continue;
          sum += z, ++n;
          low = std::min<double>(low, z), high = std::max<double>(high, z);
        }
        if (n >= 6 && high - low < jump) image.depth[image.index(c, r)] = static_cast<float>(sum / n);
      }
    }
  }
  return image;
}

// The top patch as triangles of pixel numbers, by the five configurations of Fig. C.1.
std::vector<TriangleMesh::Triangle> TopPatch(const RangeImage& image, double jump) {
  std::vector<TriangleMesh::Triangle> triangles;
  const auto add = [&](int a, int b, int c) {
    const float za = image.depth[a], zb = image.depth[b], zc = image.depth[c];
    if (std::max({za, zb, zc}) - std::min({za, zb, zc}) <= jump) triangles.push_back({a, b, c});
  };
  for (int i = 0; i + 1 < image.rows; ++i) {
    for (int j = 0; j + 1 < image.columns; ++j) {
      const int here = static_cast<int>(image.index(j, i)), right = here + 1, below = here + image.columns, across = below + 1;
      const auto has = [&](int pixel) { return std::isfinite(image.depth[pixel]); };
      if (has(here) && has(right) && has(below) && has(across)) {
        // Of the two diagonals the one with the smaller step in depth.
        if (std::abs(image.depth[here] - image.depth[across]) < std::abs(image.depth[right] - image.depth[below])) {
          add(here, below, across);
          add(here, across, right);
        } else {
          add(here, below, right);
          add(below, across, right);
        }
      } else if (has(here) && has(below) && has(right)) {
        add(here, below, right);
      } else if (has(here) && has(right) && has(across)) {
        add(here, across, right);
      } else if (has(here) && has(below) && has(across)) {
        add(here, below, across);
      } else if (has(below) && has(right) && has(across)) {
        add(below, across, right);
      }
    }
  }
  return triangles;
}

int Root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Takes away what hangs on by a corner alone, and patches of less than a fiftieth of the largest.
void KeepWholePatches(std::vector<TriangleMesh::Triangle>& triangles) {
  for (;;) {
    const int n = static_cast<int>(triangles.size());
    // Corners (3 t + k) joined over the edges at their vertex are one fan.
    std::vector<int> fan(3 * n), patch(n);
    std::iota(fan.begin(), fan.end(), 0);
    std::iota(patch.begin(), patch.end(), 0);
    std::map<std::pair<int, int>, std::pair<int, int>> edges;  // undirected edge: corner at its low and at its high end
    for (int t = 0; t < n; ++t) {
      for (int k = 0; k < 3; ++k) {
        const int k2 = (k + 1) % 3, a = triangles[t][k], b = triangles[t][k2];
        const std::pair<int, int> corners = a < b ? std::pair(3 * t + k, 3 * t + k2) : std::pair(3 * t + k2, 3 * t + k);
        const auto [it, is_new] = edges.try_emplace(std::minmax(a, b), corners);
        if (is_new) continue;
        fan[Root(fan, corners.first)] = Root(fan, it->second.first);
        fan[Root(fan, corners.second)] = Root(fan, it->second.second);
        patch[Root(patch, t)] = Root(patch, it->second.first / 3);
      }
    }
    std::vector<int> fan_size(3 * n, 0), patch_size(n, 0);
    for (int c = 0; c < 3 * n; ++c) ++fan_size[Root(fan, c)];
    for (int t = 0; t < n; ++t) ++patch_size[Root(patch, t)];
    const int largest = n > 0 ? *std::max_element(patch_size.begin(), patch_size.end()) : 0;
    std::map<int, int> best_fan;  // of each vertex
    for (int c = 0; c < 3 * n; ++c) {
      const int root = Root(fan, c), v = triangles[c / 3][c % 3];
      const auto [it, is_new] = best_fan.try_emplace(v, root);
      if (!is_new && fan_size[root] > fan_size[it->second]) it->second = root;
    }
    std::vector<TriangleMesh::Triangle> kept;
    for (int t = 0; t < n; ++t) {
      bool keep = 50 * patch_size[Root(patch, t)] >= largest;
      for (int k = 0; k < 3; ++k) keep &= best_fan[triangles[t][k]] == Root(fan, 3 * t + k);
      if (keep) kept.push_back(triangles[t]);
    }
    if (kept.size() == triangles.size()) return;
    triangles = std::move(kept);
  }
}

}  // namespace

TriangleMesh TessellateView(const RangeView& view, const ViewMeshOptions& options) {
  if (options.step < 1 || !(options.psi > 0.0)) throw std::invalid_argument("TessellateView: step must be 1 or more and psi above 0");
  const bool perspective = view.sensor.projection == SensorModel::Projection::kPerspective;
  const double focal = std::min(std::abs(view.sensor.focal_u), std::abs(view.sensor.focal_v));
  double depth_sum = 0.0;
  int n_object = 0;
  for (std::size_t pixel = 0; pixel < view.classes.size(); ++pixel) {
    if (view.IsObject(pixel) && std::isfinite(view.image.depth[pixel])) depth_sum += view.image.depth[pixel], ++n_object;
  }
  if (n_object < 3) throw std::invalid_argument("TessellateView: the view shows no object");
  const double pitch = (perspective ? depth_sum / n_object : 1.0) / focal * options.step;
  const double jump = options.max_depth_jump > 0.0 ? options.max_depth_jump : 6.0 * (pitch + view.sensor.depth_noise);

  const RangeImage image = ObjectDepths(view, options.step, jump);
  std::vector<TriangleMesh::Triangle> top = TopPatch(image, jump);
  KeepWholePatches(top);
  if (top.size() < 2) throw std::invalid_argument("TessellateView: the object is too small or too broken up in this view for a mesh");
  if (view.sensor.focal_u * view.sensor.focal_v < 0.0) {
    for (TriangleMesh::Triangle& triangle : top) std::swap(triangle[1], triangle[2]);
  }

  TriangleMesh mesh;
  std::vector<int> index(image.depth.size(), -1);
  double z_min = 1e300, z_max = -1e300;
  for (TriangleMesh::Triangle& triangle : top) {
    for (int& v : triangle) {
      if (index[v] < 0) {
        index[v] = static_cast<int>(mesh.vertices.size());
        const double z = image.depth[v];
        mesh.vertices.push_back(Unproject(view.sensor, v % image.columns * options.step, v / image.columns * options.step, z));
        z_min = std::min(z_min, z), z_max = std::max(z_max, z);
      }
      v = index[v];
    }
  }
  // (C.2); a patch square to the sensor has no depth of its own, and gets the bottom one pitch below at least.
  const double z_plane = z_max + std::max(options.psi * (z_max - z_min), pitch);
  const auto on_line = [&](int v, double z) -> Eigen::Vector3d {
    const Eigen::Vector3d& p = mesh.vertices[v];
    if (!perspective) return {p.x(), p.y(), z};
    return p * (z / p.z());
  };
  const int n_top = static_cast<int>(mesh.vertices.size());
  mesh.triangles = top;
  for (int v = 0; v < n_top; ++v) mesh.vertices.push_back(on_line(v, z_plane));
  for (const auto& [a, b, c] : top) mesh.triangles.push_back({n_top + a, n_top + c, n_top + b});

  // The border: edges run through one way only. One leaves each vertex of it, for whole patches have one fan a vertex.
  std::map<std::pair<int, int>, int> directed;
  for (const auto& t : top) {
    for (int k = 0; k < 3; ++k) ++directed[{t[k], t[(k + 1) % 3]}];
  }
  std::vector<std::pair<int, int>> border;
  double length = 0.0;
  for (const auto& [edge, count] : directed) {
    if (directed.contains({edge.second, edge.first})) continue;
    border.push_back(edge);
    length += (mesh.vertices[edge.first] - mesh.vertices[edge.second]).norm();
  }
  const double L_z = length / static_cast<double>(border.size());

  // Columns from the bottom up, a vertex every L_z, the last one well below the top.
  std::map<int, std::vector<int>> columns;
  for (const auto& [a, b] : border) {
    std::vector<int> column{n_top + a};
    for (double z = z_plane - L_z; z > mesh.vertices[a].z() + 0.5 * L_z; z -= L_z) {
      column.push_back(static_cast<int>(mesh.vertices.size()));
      mesh.vertices.push_back(on_line(a, z));
    }
    column.push_back(a);
    columns[a] = std::move(column);
  }
  for (const auto& [a, b] : border) {
    // The top patch runs from a to b, the side from b to a. Fig. C.6: squares as long as both columns have them, then a fan.
    const std::vector<int>& at_a = columns[a];
    const std::vector<int>& at_b = columns[b];
    std::size_t i = 0, j = 0;
    while (i + 2 < at_a.size() && j + 2 < at_b.size()) {
      mesh.triangles.push_back({at_b[j], at_a[i + 1], at_a[i]});
      mesh.triangles.push_back({at_b[j], at_b[j + 1], at_a[i + 1]});
      ++i, ++j;
    }
    if (i + 2 == at_a.size()) {
      for (; j + 1 < at_b.size(); ++j) {
        if (j + 2 == at_b.size()) break;
        mesh.triangles.push_back({at_b[j], at_b[j + 1], at_a[i]});
      }
      mesh.triangles.push_back({at_b[j], at_a[i + 1], at_a[i]});
      mesh.triangles.push_back({at_b[j], at_b[j + 1], at_a[i + 1]});
    } else {
      for (; i + 2 < at_a.size(); ++i) mesh.triangles.push_back({at_b[j], at_a[i + 1], at_a[i]});
      mesh.triangles.push_back({at_b[j], at_a[i + 1], at_a[i]});
      mesh.triangles.push_back({at_b[j], at_b[j + 1], at_a[i + 1]});
    }
  }
  mesh.triangle_seen.assign(mesh.triangles.size(), 0);
  std::fill(mesh.triangle_seen.begin(), mesh.triangle_seen.begin() + static_cast<std::ptrdiff_t>(top.size()), 1);
  return mesh;
}

}  // namespace geond
