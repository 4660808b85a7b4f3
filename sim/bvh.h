// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace geond::sim {

// A ray in T: origin + t direction, direction of unit length.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

// A tree of boxes over triangles (median split along the longest side), built once and read by any thread.
class Bvh {
 public:
  struct Triangle {
    Eigen::Vector3d p0, p1, p2;
    int item = 0;  // the caller's own number
  };
  Bvh() = default;
  explicit Bvh(std::vector<Triangle> triangles);

  // Calls on_hit(item, t, front) for triangles that the ray meets at 0 < t < limit, near boxes first; front is whether
  // the ray comes from outside. on_hit returns the new limit (m).
  template <typename OnHit>
  void Visit(const Ray& ray, double limit, const OnHit& on_hit) const;

 private:
  struct Node {
    Eigen::Vector3d low, high;
    int begin = 0, end = 0;  // triangles of a leaf; of an inner node the children are the next node and `right`
    int right = -1;
  };
  int Build(int begin, int end);
  static double EnterBox(const Node& node, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse, double limit);
  static bool Meet(const Triangle& triangle, const Ray& ray, double& t, bool& front);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

inline double Bvh::EnterBox(const Node& node, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse,
                            double limit) {
  double near = 0.0, far = limit;
  for (int axis = 0; axis < 3; ++axis) {
    double a = (node.low[axis] - origin[axis]) * inverse[axis];
    double b = (node.high[axis] - origin[axis]) * inverse[axis];
    if (a > b) std::swap(a, b);
    near = a > near ? a : near;  // a NaN (0 * infinity) changes nothing
    far = b < far ? b : far;
  }
  return near <= far ? near : std::numeric_limits<double>::infinity();
}

template <typename OnHit>
void Bvh::Visit(const Ray& ray, double limit, const OnHit& on_hit) const {
  if (nodes_.empty()) return;
  const Eigen::Vector3d inverse = ray.direction.cwiseInverse();
  struct Waiting {
    int node;
    double t;
  };
  Waiting stack[64];
  int depth = 0;
  const double t_root = EnterBox(nodes_[0], ray.origin, inverse, limit);
  if (t_root < limit) stack[depth++] = {0, t_root};
  while (depth > 0) {
    const Waiting top = stack[--depth];
    if (top.t >= limit) continue;
    const Node& node = nodes_[top.node];
    if (node.right < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        double t;
        bool front;
        if (Meet(triangles_[i], ray, t, front) && t < limit) limit = on_hit(triangles_[i].item, t, front);
      }
      continue;
    }
    Waiting left{top.node + 1, EnterBox(nodes_[top.node + 1], ray.origin, inverse, limit)};
    Waiting right{node.right, EnterBox(nodes_[node.right], ray.origin, inverse, limit)};
    if (left.t < right.t) std::swap(left, right);  // the nearer one is taken first, so pushed last
    if (left.t < limit) stack[depth++] = left;
    if (right.t < limit) stack[depth++] = right;
  }
}

}  // namespace geond::sim
