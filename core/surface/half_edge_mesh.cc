// SPDX-License-Identifier: Apache-2.0
#include "core/surface/half_edge_mesh.h"

#include <stdexcept>

namespace geond {

HalfEdgeMesh::HalfEdgeMesh(const TriangleMesh& mesh) : points(mesh.vertices) {
  CheckMesh(mesh);
  const MeshTopology topology = Topology(mesh);
  if (!topology.closed || !topology.manifold) {
    throw std::invalid_argument("the mesh is not a closed two-manifold: close or mend it first");
  }
  const int n = static_cast<int>(mesh.triangles.size());
  outgoing.assign(points.size(), -1);
  origin.resize(3 * n);
  twin.assign(3 * n, -1);
  crease.assign(3 * n, 0);
  for (int h = 0; h < 3 * n; ++h) {
    origin[h] = mesh.triangles[h / 3][h % 3];
    outgoing[origin[h]] = h;
  }
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  for (int h = 0; h < 3 * n; ++h) {
    const int t = neighbors[h / 3][h % 3];
    for (int k = 0; k < 3; ++k) {
      if (origin[3 * t + k] == target(h) && origin[Next(3 * t + k)] == origin[h]) twin[h] = 3 * t + k;
    }
  }
}

int HalfEdgeMesh::Valence(int v) const {
  int valence = 0;
  ForEachOutgoing(v, [&](int) { ++valence; });
  return valence;
}

bool HalfEdgeMesh::Adjacent(int u, int v) const {
  bool adjacent = false;
  ForEachOutgoing(u, [&](int h) { adjacent |= target(h) == v; });
  return adjacent;
}

Eigen::Vector3d HalfEdgeMesh::Cross(int h) const {
  const Eigen::Vector3d& a = points[origin[h]];
  return (points[target(h)] - a).cross(points[opposite(h)] - a);
}

int HalfEdgeMesh::Split(int h, const Eigen::Vector3d& p) {
  // (a b c) and (b a d) become (a m c), (m b c), (m a d), (b m d).
  const int g = twin[h], h1 = Next(h), g2 = Prev(g);
  const int b = origin[g], c = origin[Prev(h)], d = origin[g2];
  const int m = n_vertices(), e = n_half_edges(), f = e + 3;
  const int outer_bc = twin[h1], outer_db = twin[g2];
  points.push_back(p);
  origin.insert(origin.end(), {m, b, c, b, m, d});
  twin.insert(twin.end(), {f, outer_bc, h1, e, g2, outer_db});
  crease.insert(crease.end(), {crease[h], crease[h1], 0, crease[h], 0, crease[g2]});
  twin[outer_bc] = e + 1;
  twin[outer_db] = f + 2;
  origin[h1] = m;
  origin[g] = m;
  twin[h1] = e + 2;
  twin[g2] = f + 1;
  crease[h1] = crease[g2] = 0;
  outgoing.push_back(e);
  outgoing[b] = e + 1;
  return m;
}

bool HalfEdgeMesh::CanFlip(int h) const {
  const int c = opposite(h), d = opposite(twin[h]);
  return c != d && !Adjacent(c, d);
}

void HalfEdgeMesh::Flip(int h) {
  // (a b c) and (b a d) become (d c a) and (c d b).
  const int h1 = Next(h), h2 = Prev(h), g = twin[h], g1 = Next(g), g2 = Prev(g);
  const int a = origin[h], b = origin[g], c = origin[h2], d = origin[g2];
  const int bc = twin[h1], ca = twin[h2], ad = twin[g1], db = twin[g2];
  const std::uint8_t crease_bc = crease[h1], crease_ca = crease[h2], crease_ad = crease[g1], crease_db = crease[g2];
  const auto set = [&](int edge, int from, int other, std::uint8_t is_crease) {
    origin[edge] = from;
    twin[edge] = other;
    twin[other] = edge;
    crease[edge] = is_crease;
    outgoing[from] = edge;
  };
  set(h1, c, ca, crease_ca);
  set(h2, a, ad, crease_ad);
  set(g1, d, db, crease_db);
  set(g2, b, bc, crease_bc);
  set(h, d, g, 0);
  set(g, c, h, 0);
}

bool HalfEdgeMesh::CanCollapse(int h) const {
  const int a = origin[h], b = target(h), c = opposite(h), d = opposite(twin[h]);
  if (c == d) return false;
  int common = 0;
  ForEachOutgoing(a, [&](int e) { common += target(e) != b && Adjacent(b, target(e)); });
  return common == 2 && Valence(c) > 3 && Valence(d) > 3;
}

void HalfEdgeMesh::Collapse(int h) {
  const int g = twin[h], a = origin[h], b = target(h), c = opposite(h), d = opposite(g);
  std::vector<int> star;
  ForEachOutgoing(a, [&](int e) { star.push_back(e); });
  for (int e : star) origin[e] = b;
  const auto join = [&](int one, int other) {
    twin[one] = other;
    twin[other] = one;
    crease[one] = crease[other] = crease[one] | crease[other];
  };
  const int cb = twin[Next(h)], ac = twin[Prev(h)], da = twin[Next(g)], bd = twin[Prev(g)];
  join(cb, ac);
  join(da, bd);
  for (int e : {h, g}) origin[e] = origin[Next(e)] = origin[Prev(e)] = -1;
  outgoing[a] = -1;
  outgoing[b] = bd;
  outgoing[c] = cb;
  outgoing[d] = da;
}

TriangleMesh HalfEdgeMesh::ToMesh() const {
  TriangleMesh mesh;
  std::vector<int> index(points.size(), -1);
  for (int v = 0; v < n_vertices(); ++v) {
    if (outgoing[v] < 0) continue;
    index[v] = static_cast<int>(mesh.vertices.size());
    mesh.vertices.push_back(points[v]);
  }
  for (int h = 0; h < n_half_edges(); h += 3) {
    if (alive(h)) mesh.triangles.push_back({index[origin[h]], index[origin[h + 1]], index[origin[h + 2]]});
  }
  return mesh;
}

}  // namespace geond
