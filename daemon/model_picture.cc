// SPDX-License-Identifier: Apache-2.0
#include "daemon/model_picture.h"

#include <algorithm>
#include <cstdio>

#include "core/picture/image.h"

namespace geond::daemon {

ObjectPictureData PictureData(const ObjectModel& model) {
  ObjectPictureData data;
  data.cloud = model.cloud;
  data.mesh = model.mesh;
  data.charge = model.charge.density;
  data.labels = model.segmentation.labels;
  for (const DescribedPart& part : model.description.parts) {
    const Geon& geon = part.geon();
    std::string name(GeonTypeName(geon.type));
    std::replace(name.begin(), name.end(), '_', ' ');
    char size[64];
    std::snprintf(size, sizeof size, " %.0f x %.0f x %.0f mm", 2e3 * geon.size.x(), 2e3 * geon.size.y(), 2e3 * geon.size.z());
    data.geons.push_back({GeonMesh(geon, std::max(0.08 * geon.size.mean(), 1e-6)), name + size});
  }
  return data;
}

void WritePicture(const ObjectModel& model, const ObjectPictureOptions& options, const std::filesystem::path& path) {
  WritePng(ObjectPicture(PictureData(model), options), path);
}

}  // namespace geond::daemon
