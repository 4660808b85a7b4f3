// SPDX-License-Identifier: Apache-2.0
#include "core/surface/remesher.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace geond {
namespace {

// The bounds on edges that keep splitting and collapsing from undoing each other (Botsch and Kobbelt 2004).
constexpr double kLong = 4.0 / 3.0;
constexpr double kShort = 4.0 / 5.0;
// Creases closer to each other than this (of the wanted edge) cannot both be kept.
constexpr double kMerge = 0.4;

}  // namespace

Remesher::Remesher(HalfEdgeMesh mesh, double edge_length, int threads)
    : mesh_(std::move(mesh)), fixed_(mesh_.points.size(), 0), edge_length_(edge_length), threads_(threads) {}

int Remesher::CountTriangles() const {
  int n = 0;
  for (int h = 0; h < mesh_.n_half_edges(); h += 3) n += mesh_.alive(h);
  return n;
}

int Remesher::CreaseEdges(int v) const {
  int n = 0;
  mesh_.ForEachOutgoing(v, [&](int h) { n += mesh_.crease[h]; });
  return n;
}

void Remesher::MarkCreases(double angle) {
  for (int h = 0; h < mesh_.n_half_edges(); ++h) {
    if (!mesh_.alive(h) || h > mesh_.twin[h]) continue;
    const Eigen::Vector3d n = mesh_.Cross(h), m = mesh_.Cross(mesh_.twin[h]);
    const bool bent = std::atan2(n.cross(m).norm(), n.dot(m)) > angle;
    mesh_.crease[h] = mesh_.crease[mesh_.twin[h]] = bent;
  }
  for (int v = 0; v < mesh_.n_vertices(); ++v) {
    if (mesh_.outgoing[v] < 0) continue;
    std::vector<Eigen::Vector3d> along;
    mesh_.ForEachOutgoing(v, [&](int h) {
      if (mesh_.crease[h]) along.push_back((mesh_.points[mesh_.target(h)] - mesh_.points[v]).normalized());
    });
    const bool smooth = along.empty() || (along.size() == 2 && along[0].dot(along[1]) < -std::cos(0.8));
    fixed_[v] = !smooth;
  }
}

// Whether a triangle at v, but those at the edge ignore_h, turns over when v moves.
bool Remesher::TurnsOver(int v, const Eigen::Vector3d& to, int ignore_h) const {
  bool turns = false;
  mesh_.ForEachOutgoing(v, [&](int h) {
    if (turns || h == ignore_h || (ignore_h >= 0 && h == HalfEdgeMesh::Next(mesh_.twin[ignore_h]))) return;
    const Eigen::Vector3d b = mesh_.points[mesh_.target(h)], c = mesh_.points[mesh_.opposite(h)];
    const Eigen::Vector3d before = (b - mesh_.points[v]).cross(c - mesh_.points[v]);
    const Eigen::Vector3d after = (b - to).cross(c - to);
    // Slivers have no normal to speak of: any triangle with more area than that is better.
    const double longest = std::max({(b - c).squaredNorm(), (b - to).squaredNorm(), (c - to).squaredNorm()});
    const bool was_sliver = before.norm() < 0.02 * std::max((b - c).squaredNorm(), (b - mesh_.points[v]).squaredNorm());
    if (after.norm() < 0.02 * longest && !was_sliver) turns = true;
    if (!was_sliver && before.dot(after) < 0.3 * before.norm() * after.norm()) turns = true;
  });
  return turns;
}

void Remesher::SplitLongEdges() {
  const double limit = kLong * kLong * edge_length_ * edge_length_;
  double longest = limit;
  for (int h = 0; h < mesh_.n_half_edges(); ++h) {
    if (mesh_.alive(h)) longest = std::max(longest, mesh_.SquaredLength(h));
  }
  // The longest first, class by class: split in any order, thin triangles beget thinner ones without end.
  for (bool last = false; !last;) {
    longest = std::max(limit, 0.5 * longest);
    last = longest <= limit;
    for (int h = 0; h < mesh_.n_half_edges(); ++h) {  // half-edges made on the way are looked at too
      if (!mesh_.alive(h)) continue;
      while (mesh_.SquaredLength(h) > longest) {
        mesh_.Split(h, 0.5 * (mesh_.points[mesh_.origin[h]] + mesh_.points[mesh_.target(h)]));
        fixed_.push_back(0);
      }
    }
  }
}

bool Remesher::TryCollapse(int h, bool merge_creases, double longest) {
  const int a = mesh_.origin[h], b = mesh_.target(h), g = mesh_.twin[h];
  const double squared_length = mesh_.SquaredLength(h);
  if (squared_length > longest * longest) return false;
  const bool merge = merge_creases && squared_length < kMerge * kMerge * edge_length_ * edge_length_;
  const int creases_a = CreaseEdges(a), creases_b = CreaseEdges(b);
  if (!merge) {
    if (fixed_[a] || (creases_a > 0 && !mesh_.crease[h])) return false;
    for (int side : {h, g}) {
      if (mesh_.crease[HalfEdgeMesh::Next(side)] && mesh_.crease[HalfEdgeMesh::Prev(side)]) return false;
    }
  } else if (fixed_[a] && !fixed_[b]) {
    return false;  // the other way round
  }
  const bool free_a = !fixed_[a] && creases_a <= creases_b, free_b = !fixed_[b] && creases_b <= creases_a;
  const Eigen::Vector3d& from = mesh_.points[a];
  const Eigen::Vector3d& to = mesh_.points[b];
  const Eigen::Vector3d position = free_a && free_b ? Eigen::Vector3d(0.5 * (from + to)) : to;
  const double limit = (longest > kShort * edge_length_ ? 1.7 : kLong) * edge_length_;
  bool too_long = false;
  for (int v : {a, b}) {
    mesh_.ForEachOutgoing(v, [&](int e) {
      too_long |= (mesh_.points[mesh_.target(e)] - position).squaredNorm() > limit * limit &&
                  mesh_.target(e) != a && mesh_.target(e) != b;
    });
  }
  if (too_long || !mesh_.CanCollapse(h) || TurnsOver(a, position, h) || TurnsOver(b, position, g)) return false;
  fixed_[b] |= fixed_[a];
  mesh_.Collapse(h);
  mesh_.points[b] = position;
  return true;
}

void Remesher::CollapseSlivers(double angle) {
  const double sine = std::sin(angle);
  for (int h = 0; h < mesh_.n_half_edges(); h += 3) {
    if (!mesh_.alive(h) || SmallestAngle(mesh_.points[mesh_.origin[h]], mesh_.points[mesh_.origin[h + 1]],
                                         mesh_.points[mesh_.origin[h + 2]]) > sine) {
      continue;
    }
    int shortest = h;
    for (int e : {h + 1, h + 2}) {
      if (mesh_.SquaredLength(e) < mesh_.SquaredLength(shortest)) shortest = e;
    }
    if (!TryCollapse(shortest, true, 0.9 * edge_length_)) TryCollapse(mesh_.twin[shortest], true, 0.9 * edge_length_);
  }
}

void Remesher::CollapseShortEdges(bool merge_creases) {
  for (int pass = 0; pass < 6; ++pass) {
    int n = 0;
    for (int h = 0; h < mesh_.n_half_edges(); ++h) {
      if (mesh_.alive(h)) n += TryCollapse(h, merge_creases, kShort * edge_length_);
    }
    if (n < 1 + CountTriangles() / 200) return;
  }
}

// A flip must not cut through the surface: the two new triangles may not be bent more than the old ones were (beyond a
// little), nor face away from them.
bool Remesher::FlipKeepsShape(int h) const {
  const int g = mesh_.twin[h];
  const Eigen::Vector3d &a = mesh_.points[mesh_.origin[h]], &b = mesh_.points[mesh_.target(h)];
  const Eigen::Vector3d &c = mesh_.points[mesh_.opposite(h)], &d = mesh_.points[mesh_.opposite(g)];
  const Eigen::Vector3d n = (b - a).cross(c - a), m = (a - b).cross(d - b);
  const Eigen::Vector3d n_new = (c - d).cross(a - d), m_new = (d - c).cross(b - c);
  const Eigen::Vector3d sum = n + m;
  if (n_new.dot(sum) <= 0.2 * n_new.norm() * sum.norm() || m_new.dot(sum) <= 0.2 * m_new.norm() * sum.norm()) return false;
  const double before = std::atan2(n.cross(m).norm(), n.dot(m));
  const double after = std::atan2(n_new.cross(m_new).norm(), n_new.dot(m_new));
  return after <= std::max(before + 0.1, 0.35);
}

void Remesher::FlipToValence() {
  for (int h = 0; h < mesh_.n_half_edges(); ++h) {
    if (!mesh_.alive(h) || h > mesh_.twin[h] || mesh_.crease[h]) continue;
    int gain = 0;
    const auto count = [&](int v, int change) {
      const int excess = mesh_.Valence(v) - 6;
      gain += excess * excess - (excess + change) * (excess + change);
    };
    count(mesh_.origin[h], -1);
    count(mesh_.target(h), -1);
    count(mesh_.opposite(h), 1);
    count(mesh_.opposite(mesh_.twin[h]), 1);
    if (gain > 0 && FlipKeepsShape(h) && mesh_.CanFlip(h)) mesh_.Flip(h);
  }
}

double Remesher::SmallestAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) const {
  // The smallest angle lies opposite the shortest side; its sine is the area over the product of the other two.
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double longer = ab * bc * ca / std::min({ab, bc, ca});
  return longer > 0.0 ? (b - a).cross(c - a).norm() / std::sqrt(longer) : 0.0;
}

void Remesher::FlipToAngle() {
  for (int pass = 0; pass < 3; ++pass) {
    int n = 0;
    for (int h = 0; h < mesh_.n_half_edges(); ++h) {
      if (!mesh_.alive(h) || h > mesh_.twin[h] || mesh_.crease[h]) continue;
      const Eigen::Vector3d &a = mesh_.points[mesh_.origin[h]], &b = mesh_.points[mesh_.target(h)];
      const Eigen::Vector3d &c = mesh_.points[mesh_.opposite(h)], &d = mesh_.points[mesh_.opposite(mesh_.twin[h])];
      const double before = std::min(SmallestAngle(a, b, c), SmallestAngle(b, a, d));
      const double after = std::min(SmallestAngle(d, c, a), SmallestAngle(c, d, b));
      if (after > before + 1e-3 && FlipKeepsShape(h) && mesh_.CanFlip(h)) {
        mesh_.Flip(h);
        ++n;
      }
    }
    if (n == 0) return;
  }
}

void Remesher::Relax(const SurfaceProjection& on_surface, const SurfaceProjection& on_crease) {
  std::vector<Eigen::Vector3d> moved(mesh_.points);
  ParallelFor(mesh_.n_vertices(), threads_, 256, [&](std::ptrdiff_t v_long) {
    const int v = static_cast<int>(v_long);
    if (mesh_.outgoing[v] < 0 || fixed_[v]) return;
    const Eigen::Vector3d& p = mesh_.points[v];
    Eigen::Vector3d normal = Eigen::Vector3d::Zero(), center = Eigen::Vector3d::Zero();
    Eigen::Vector3d crease_sum = Eigen::Vector3d::Zero();
    double weight = 0.0;
    int creases = 0;
    mesh_.ForEachOutgoing(v, [&](int h) {
      const Eigen::Vector3d &b = mesh_.points[mesh_.target(h)], &c = mesh_.points[mesh_.opposite(h)];
      const Eigen::Vector3d cross = (b - p).cross(c - p);
      const double area = cross.norm();
      normal += cross;
      weight += area;
      center += area * (p + b + c) / 3.0;
      if (mesh_.crease[h]) {
        ++creases;
        crease_sum += b;
      }
    });
    if (creases == 2) {
      moved[v] = on_crease(0.5 * p + 0.25 * crease_sum, normal.stableNormalized());
    } else if (creases == 0 && weight > 0.0) {
      normal = normal.stableNormalized();
      center /= weight;
      moved[v] = on_surface(center + normal * normal.dot(p - center), normal);
    }
  });
  const double limit = edge_length_;
  for (int v = 0; v < mesh_.n_vertices(); ++v) {
    if (mesh_.outgoing[v] < 0 || fixed_[v] || !moved[v].allFinite()) continue;
    const Eigen::Vector3d step = moved[v] - mesh_.points[v];
    if (step.squaredNorm() > limit * limit) continue;
    for (double share : {1.0, 0.5}) {
      const Eigen::Vector3d to = mesh_.points[v] + share * step;
      if (TurnsOver(v, to, -1)) continue;
      mesh_.points[v] = to;
      break;
    }
  }
}

}  // namespace geond
