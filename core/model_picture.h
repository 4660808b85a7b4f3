// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/object_model.h"
#include "core/picture/object_picture.h"

namespace geond {

// An object model as the panels of a picture: cloud, mesh by charge, mesh by part, geons over the points. What the model
// lacks is left out.
Image ModelPicture(const ObjectModel& model, const std::string& title = {}, const ObjectPictureOptions& options = {});

}  // namespace geond
