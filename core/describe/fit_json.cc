// SPDX-License-Identifier: Apache-2.0
#include "core/describe/fit_json.h"

#include <cmath>
#include <string>

namespace geond {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMillimetres = 1e3;  // in a metre

}  // namespace

Json FiniteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json DeviationToJson(const GeonFit& fit) {
  const auto some = [&](std::size_t from, std::size_t count, double factor) {
    Json values = Json::array();
    for (std::size_t i = from; i < from + count; ++i) values.push_back(FiniteOrNull(fit.deviation[i] * factor));
    return values;
  };
  return {{"position_mm", some(0, 3, kMillimetres)},
          {"rotation_rad", some(3, 3, 1.0)},
          {"size_mm", some(6, 3, kMillimetres)},
          {"taper", some(9, 2, 1.0)},
          {"bend_per_mm", FiniteOrNull(fit.deviation[11] / kMillimetres)}};
}

Json EndsToJson(const GeonFit& fit) {
  const auto word = [](EndState state) {
    return state == EndState::kSeen ? "seen" : state == EndState::kBounded ? "bounded" : "hidden";
  };
  Json json = Json::object();
  for (int k = 0; k < 3; ++k)
    json[std::string(1, "xyz"[k])] = Json::array({word(fit.ends[k][0]), word(fit.ends[k][1])});
  return json;
}

std::array<bool, 3> SizesAtLeast(const GeonFit& fit) {
  const GeonType base = BaseType(fit.geon.type);
  std::array<bool, 3> least{};
  for (int k = 0; k < 3; ++k) {
    const bool round = base == GeonType::kEllipsoid || (base == GeonType::kCylinder && k < 2);
    least[k] = !round && (fit.ends[k][0] == EndState::kHidden || fit.ends[k][1] == EndState::kHidden);
  }
  return least;
}

}  // namespace geond
