// SPDX-License-Identifier: Apache-2.0
#include "core/surface/signed_grid.h"

#include <stdexcept>
#include <string>

namespace geond {
namespace {

// A cell is cut along its main diagonal into six tetrahedra: 0, a corner on one axis, a corner on two, 7 (Kuhn 1960). Corner
// c has x, y, z in its bits 0, 1, 2. Odd orders of the axes give left-handed ones: their corners are listed swapped.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra{{{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}}};

}  // namespace

SignedGrid::SignedGrid(const Eigen::AlignedBox3d& box, double step_, float fill, std::size_t max_nodes) : step(step_) {
  double nodes = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::floor(box.min()[axis] / step) - 1, high = std::ceil(box.max()[axis] / step) + 1;
    origin[axis] = low * step;
    nodes *= high - low + 1;
    if (!(nodes < static_cast<double>(max_nodes))) {
      throw std::invalid_argument("voxels of " + std::to_string(step * 1e3) + " mm are too small for an object of " +
                                  std::to_string(box.diagonal().norm() * 1e3) + " mm");
    }
    size[axis] = static_cast<int>(high - low) + 1;
  }
  value.assign(count(), fill);
}

double SignedGrid::Sample(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const {
  const Eigen::Vector3d at = (p - origin) / step;
  std::array<int, 3> cell;
  Eigen::Vector3d t;
  for (int axis = 0; axis < 3; ++axis) {
    const double inside = std::clamp(at[axis], 0.0, size[axis] - 1.0);
    cell[axis] = std::min(static_cast<int>(inside), size[axis] - 2);
    t[axis] = inside - cell[axis];
  }
  std::array<double, 8> v;
  for (int c = 0; c < 8; ++c) v[c] = value[index(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2))];
  const double x00 = v[0] + t.x() * (v[1] - v[0]), x10 = v[2] + t.x() * (v[3] - v[2]);
  const double x01 = v[4] + t.x() * (v[5] - v[4]), x11 = v[6] + t.x() * (v[7] - v[6]);
  const double y0 = x00 + t.y() * (x10 - x00), y1 = x01 + t.y() * (x11 - x01);
  if (gradient) {
    const auto mix = [](double a, double b, double s) { return a + s * (b - a); };
    gradient->x() = mix(mix(v[1] - v[0], v[3] - v[2], t.y()), mix(v[5] - v[4], v[7] - v[6], t.y()), t.z()) / step;
    gradient->y() = mix(x10 - x00, x11 - x01, t.z()) / step;
    gradient->z() = (y1 - y0) / step;
  }
  return y0 + t.z() * (y1 - y0);
}

TriangleMesh MarchingTetrahedra(const SignedGrid& grid) {
  TriangleMesh mesh;
  const int nx = grid.size[0], ny = grid.size[1], nz = grid.size[2];
  // A node owns the seven edges that leave it in directions 1 to 7. Vertices on edges of two layers are remembered.
  const std::size_t layer_size = static_cast<std::size_t>(nx) * ny;
  std::array<std::vector<int>, 2> layers;
  for (auto& layer : layers) layer.assign(layer_size * 8, -1);

  for (int k = 0; k + 1 < nz; ++k) {
    std::fill(layers[(k + 1) % 2].begin(), layers[(k + 1) % 2].end(), -1);
    for (int j = 0; j + 1 < ny; ++j) {
      for (int i = 0; i + 1 < nx; ++i) {
        std::array<float, 8> v;
        int inside = 0;
        for (int c = 0; c < 8; ++c) {
          v[c] = grid.value[grid.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
          inside |= (v[c] < 0.0f) << c;
        }
        if (inside == 0 || inside == 255) continue;
        const auto vertex = [&](int from, int to) {
          if (from > to) std::swap(from, to);  // the lower corner's bits are among the upper one's
          const std::size_t node = static_cast<std::size_t>(j + (from >> 1 & 1)) * nx + i + (from & 1);
          int& slot = layers[(k + (from >> 2)) % 2][8 * node + (to - from)];
          if (slot < 0) {
            slot = static_cast<int>(mesh.vertices.size());
            const double a = v[from], b = v[to];
            const double t = std::clamp(a / (a - b), 0.01, 0.99);
            const Eigen::Vector3d p = grid.node(i + (from & 1), j + (from >> 1 & 1), k + (from >> 2));
            const Eigen::Vector3d q = grid.node(i + (to & 1), j + (to >> 1 & 1), k + (to >> 2));
            mesh.vertices.push_back(p + t * (q - p));
          }
          return slot;
        };
        for (const auto& [a, b, c, d] : kTetrahedra) {
          const auto in = [&](int corner) { return (inside >> corner & 1) != 0; };
          std::array<int, 4> tet{a, b, c, d};
          const int n_in = in(a) + in(b) + in(c) + in(d);
          if (n_in == 0 || n_in == 4) continue;
          // Bring the corners inside to the front by even permutations of the right-handed tetrahedron.
          const auto rotate = [&](int x, int y, int z) {
            const int first = tet[x];
            tet[x] = tet[y], tet[y] = tet[z], tet[z] = first;
          };
          if (n_in == 1 || n_in == 3) {
            const bool alone_in = n_in == 1;
            if (in(tet[1]) == alone_in) rotate(0, 1, 2);
            else if (in(tet[2]) == alone_in) rotate(0, 2, 1);
            else if (in(tet[3]) == alone_in) rotate(0, 3, 1);
            const int p = vertex(tet[0], tet[1]), q = vertex(tet[0], tet[2]), r = vertex(tet[0], tet[3]);
            mesh.triangles.push_back(alone_in ? TriangleMesh::Triangle{p, q, r} : TriangleMesh::Triangle{p, r, q});
          } else {
            if (in(tet[0]) && in(tet[2])) rotate(1, 2, 3);
            else if (in(tet[0]) && in(tet[3])) rotate(1, 3, 2);
            else if (in(tet[1]) && in(tet[2])) rotate(0, 1, 2);
            else if (in(tet[1]) && in(tet[3])) rotate(0, 1, 3);
            else if (in(tet[2]) && in(tet[3])) { std::swap(tet[0], tet[2]); std::swap(tet[1], tet[3]); }
            // rotate() of two inside corners may leave them as (1, 0): the quad is turned with them, not mirrored.
            const int p = vertex(tet[0], tet[2]), q = vertex(tet[0], tet[3]), r = vertex(tet[1], tet[3]), s = vertex(tet[1], tet[2]);
            mesh.triangles.push_back({p, q, r});
            mesh.triangles.push_back({p, r, s});
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace geond
