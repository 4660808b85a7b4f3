// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/object_model.h"
#include "core/picture/object_picture.h"

namespace geond::daemon {

// What a model has to show, with a surface for every fitted geon.
ObjectPictureData PictureData(const ObjectModel& model);

// Draws a model as a PNG, without a display. Throws FileError, std::invalid_argument as ObjectPicture.
void WritePicture(const ObjectModel& model, const ObjectPictureOptions& options, const std::filesystem::path& path);

}  // namespace geond::daemon
