// SPDX-License-Identifier: Apache-2.0
#include "core/model_picture.h"

#include <algorithm>

#include "core/base/printed.h"

namespace geond {
namespace {

// Edges of a drawn geon, of its largest half size.
constexpr double kEdgeShare = 0.06;

std::string Label(const Geon& geon) {
  std::string name(GeonTypeName(geon.type));
  std::replace(name.begin(), name.end(), '_', ' ');
  return Printed("%s %.3g x %.3g x %.3g mm", name.c_str(), 2e3 * geon.size.x(), 2e3 * geon.size.y(), 2e3 * geon.size.z());
}

}  // namespace

Image ModelPicture(const ObjectModel& model, const std::string& title, const ObjectPictureOptions& options) {
  ObjectPictureData data;
  data.title = title;
  data.cloud = model.cloud;
  data.mesh = model.mesh;
  data.charge = model.charge.density;
  data.labels = model.segmentation.labels;
  for (const std::vector<GeonFit>& fits : model.fits) {
    if (fits.empty()) {
      data.geons.emplace_back();  // keeps the colours of the parts
      continue;
    }
    const Geon& geon = fits.front().geon;
    data.geons.push_back({GeonMesh(geon, kEdgeShare * geon.size.maxCoeff()), Label(geon)});
  }
  return ObjectPicture(data, options);
}

}  // namespace geond
