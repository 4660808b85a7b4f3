// SPDX-License-Identifier: Apache-2.0
#include "core/describe/relations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace geond {
namespace {

// Direction cosine with the vertical above which a part counts as above or below another.
constexpr double kVerticalCosine = 0.5;
// Sizes within this ratio are called alike.
constexpr double kAlike = 1.25;

struct Contact {
  Eigen::Vector3d weighted_sum = Eigen::Vector3d::Zero();
  double length = 0.0;
};

// The cut between each two parts (labels, lower first): its length and the sum of its edges' middles by length.
std::map<std::pair<int, int>, Contact> FindContacts(const TriangleMesh& mesh, const std::vector<int>& labels) {
  std::map<std::pair<int, int>, Contact> contacts;
  const std::vector<std::array<int, 3>> neighbors = TriangleNeighbors(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int side = 0; side < 3; ++side) {
      const int other = neighbors[t][side];
      if (other < 0 || labels[t] < 0 || labels[t] >= labels[other]) continue;
      const Eigen::Vector3d& from = mesh.vertices[mesh.triangles[t][side]];
      const Eigen::Vector3d& to = mesh.vertices[mesh.triangles[t][(side + 1) % 3]];
      Contact& contact = contacts[{labels[t], labels[other]}];
      contact.weighted_sum += (to - from).norm() * 0.5 * (from + to);
      contact.length += (to - from).norm();
    }
  }
  return contacts;
}

std::string TypeWords(const Geon& geon) {
  std::string words(GeonTypeName(geon.type));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string Sentence(const PartRelation& relation, const DescribedPart& a, const DescribedPart& b) {
  const std::string name_a = "part " + std::to_string(a.id) + " (" + TypeWords(a.geon()) + ")";
  const std::string name_b = "part " + std::to_string(b.id) + " (" + TypeWords(b.geon()) + ")";
  std::string joint = relation.joint;
  std::replace(joint.begin(), joint.end(), '_', ' ');
  std::string sentence = name_b;
  if (relation.vertical == "beside") {
    sentence += " is beside " + name_a;
  } else {
    sentence += " is " + relation.vertical + " " + name_a;
  }
  sentence += relation.touching ? ", joined " + joint : ", not touching it";
  const double ratio = relation.size_ratio;
  if (ratio > kAlike) {
    sentence += ", and is smaller";
  } else if (ratio < 1.0 / kAlike) {
    sentence += ", and is larger";
  } else {
    sentence += ", and is about as large";
  }
  return sentence;
}

PartRelation Relate(const DescribedPart& a, const DescribedPart& b) {
  PartRelation relation;
  relation.a = a.id;
  relation.b = b.id;
  const Eigen::Vector3d between = b.geon().X_TG.translation() - a.geon().X_TG.translation();
  relation.distance = between.norm();
  if (relation.distance > 0) relation.direction = between / relation.distance;
  const double up = relation.direction.z();
  relation.vertical = up > kVerticalCosine ? "above" : up < -kVerticalCosine ? "below" : "beside";
  relation.size_ratio = GeonVolume(a.geon()) / GeonVolume(b.geon());
  return relation;
}

void SetJoint(const DescribedPart& a, const DescribedPart& b, PartRelation& relation) {
  relation.joint = std::string(IsAtEnd(a.geon(), relation.contact) ? "end" : "side") + "_to_" +
                   (IsAtEnd(b.geon(), relation.contact) ? "end" : "side");
  relation.sentence = Sentence(relation, a, b);
}

}  // namespace

double GeonVolume(const Geon& geon) {
  const double box = geon.size.prod();
  const double taper = 1.0 + geon.taper.x() * geon.taper.y() / 3.0;
  if (geon.type == GeonType::kEllipsoid) return 4.0 / 3.0 * std::numbers::pi * box;
  return (BaseType(geon.type) == GeonType::kCylinder ? 2.0 * std::numbers::pi : 8.0) * box * taper;
}

bool IsAtEnd(const Geon& geon, const Eigen::Vector3d& p_T) {
  Eigen::Vector3d p_G = Inverse(geon.X_TG) * p_T;
  if (geon.bend > 0) {  // straighten (correction 8 of the thesis)
    const double x = p_G.x(), z = p_G.z(), k = geon.bend;
    p_G.x() = (2.0 * x - k * (x * x + z * z)) / (1.0 + std::hypot(k * z, 1.0 - k * x));
    p_G.z() = std::atan2(k * z, 1.0 - k * x) / k;
  }
  int axis = 2;
  if (geon.type == GeonType::kEllipsoid || geon.type == GeonType::kCuboid) {
    Eigen::Vector3d sorted = geon.size;
    std::sort(sorted.data(), sorted.data() + 3);
    if (sorted[2] < 1.15 * sorted[1]) return true;
    geon.size.maxCoeff(&axis);
  }
  const Eigen::Vector3d scaled = p_G.cwiseAbs().cwiseQuotient(geon.size);
  return scaled[axis] >= std::max(scaled[(axis + 1) % 3], scaled[(axis + 2) % 3]);
}

std::vector<PartRelation> RelateParts(const TriangleMesh& mesh, const PartSegmentation& segmentation,
                                      const std::vector<DescribedPart>& parts) {
  std::map<int, const DescribedPart*> part_of_label;
  for (const DescribedPart& part : parts) part_of_label[part.id - 1] = &part;

  std::vector<PartRelation> relations;
  std::set<int> related;
  for (const auto& [pair, contact] : FindContacts(mesh, segmentation.labels)) {
    const auto a = part_of_label.find(pair.first), b = part_of_label.find(pair.second);
    if (a == part_of_label.end() || b == part_of_label.end()) continue;
    PartRelation relation = Relate(*a->second, *b->second);
    relation.touching = true;
    relation.contact = contact.weighted_sum / contact.length;
    relation.boundary_length = contact.length;
    for (const PartBoundary& boundary : segmentation.boundaries) {
      if (boundary.a == pair.first && boundary.b == pair.second) relation.boundary_strength = boundary.strength;
    }
    SetJoint(*a->second, *b->second, relation);
    relations.push_back(relation);
    related.insert({relation.a, relation.b});
  }

  for (const DescribedPart& part : parts) {
    if (related.contains(part.id) || parts.size() < 2) continue;
    const DescribedPart* nearest = nullptr;
    const auto distance = [&](const DescribedPart& other) {
      return (other.geon().X_TG.translation() - part.geon().X_TG.translation()).norm();
    };
    for (const DescribedPart& other : parts) {
      if (other.id != part.id && (!nearest || distance(other) < distance(*nearest))) nearest = &other;
    }
    const DescribedPart& a = nearest->id < part.id ? *nearest : part;
    const DescribedPart& b = nearest->id < part.id ? part : *nearest;
    PartRelation relation = Relate(a, b);
    relation.contact = 0.5 * (a.geon().X_TG.translation() + b.geon().X_TG.translation());
    SetJoint(a, b, relation);
    relations.push_back(relation);
    related.insert({relation.a, relation.b});
  }
  return relations;
}

}  // namespace geond
