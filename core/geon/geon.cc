// SPDX-License-Identifier: Apache-2.0
#include "core/geon/geon.h"

#include <stdexcept>
#include <string>

namespace geond {

bool IsTapered(GeonType type) { return type == GeonType::kTaperedCylinder || type == GeonType::kTaperedCuboid; }

bool IsCurved(GeonType type) { return type == GeonType::kCurvedCylinder || type == GeonType::kCurvedCuboid; }

GeonType BaseType(GeonType type) {
  switch (type) {
    case GeonType::kEllipsoid: return GeonType::kEllipsoid;
    case GeonType::kCylinder:
    case GeonType::kTaperedCylinder:
    case GeonType::kCurvedCylinder: return GeonType::kCylinder;
    case GeonType::kCuboid:
    case GeonType::kTaperedCuboid:
    case GeonType::kCurvedCuboid: return GeonType::kCuboid;
  }
  throw std::invalid_argument("no geon type has the number " + std::to_string(static_cast<int>(type)));
}

std::string_view GeonTypeName(GeonType type) {
  switch (type) {
    case GeonType::kEllipsoid: return "ellipsoid";
    case GeonType::kCylinder: return "cylinder";
    case GeonType::kCuboid: return "cuboid";
    case GeonType::kTaperedCylinder: return "tapered_cylinder";
    case GeonType::kTaperedCuboid: return "tapered_cuboid";
    case GeonType::kCurvedCylinder: return "curved_cylinder";
    case GeonType::kCurvedCuboid: return "curved_cuboid";
  }
  throw std::invalid_argument("no geon type has the number " + std::to_string(static_cast<int>(type)));
}

GeonType GeonTypeFromName(std::string_view name) {
  std::string names;
  for (const GeonType type : kGeonTypes) {
    if (GeonTypeName(type) == name) return type;
    names += (names.empty() ? "" : ", ") + std::string(GeonTypeName(type));
  }
  throw std::invalid_argument("no geon is called \"" + std::string(name) + "\"; there are " + names);
}

}  // namespace geond
