// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "sim/scene.h"

namespace geond::reproduce {

// The objects of the experiments. The thesis' own are not public: these are built by us.

// One geon on the table (z = 0), its lowest point there; lengths in mm, turned by rpy degrees about x, then y, then z.
sim::Scene SingleGeon(GeonType type, const Eigen::Vector3d& size_mm, const Eigen::Vector2d& taper, double bend_per_mm,
                      const Eigen::Vector3d& rpy_deg, const std::string& name);

// The seven wooden objects of Table 6.1, one of each type, about 100 mm across.
std::vector<sim::Scene> SevenObjects();

// The pin of Table 1.1 from its printed sizes and tapers, its neck 3 mm lower than printed so that the parts meet.
sim::Scene BowlingPin();
sim::Scene Vase();           // a ball with a cylinder on top (Fig. 6.10)
sim::Scene Owl();            // stump, body and head (Fig. 6.13)
sim::Scene Clock();          // an alarm clock's round body with two bells (Fig. 6.14)
sim::Scene Elephant();       // body, head, four legs, trunk, two ears, two tusks (Fig. 6.12)
sim::Scene CylinderAndBall();  // a cylinder with an ellipsoid on top (Fig. 6.25 a)

// Eleven bananas: bent tubes with thinner, rounded ends, five ridges and a bend that varies along them; sizes, bends and
// irregularities drawn from fixed ranges by a fixed seed. None of them is a geon.
std::vector<sim::Scene> Bananas(int count = 11);
// The curved plastic tube of Fig. 6.24: a perfect curved cylinder of a banana's size.
sim::Scene Tube();

// One closed mesh of about `triangles` round the union of a scene's geons, and which geon each triangle lies on.
struct UnionSurface {
  TriangleMesh mesh;
  std::vector<int> labels;
};
UnionSurface MeshOfUnion(const sim::Scene& scene, int triangles, int threads, std::stop_token stop);

// Which geon of the scene each triangle lies on.
std::vector<int> TrueLabels(const sim::Scene& scene, const TriangleMesh& mesh);

// Share of the pairs of triangles (weighted by area) on which two labellings agree, 0 to 1 (Rand index); triangles with
// label -1 in either do not count.
double RandIndex(const TriangleMesh& mesh, const std::vector<int>& a, const std::vector<int>& b);

}  // namespace geond::reproduce
