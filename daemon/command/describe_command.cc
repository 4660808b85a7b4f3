// SPDX-License-Identifier: Apache-2.0
#include "core/model_picture.h"
#include "daemon/command/input.h"
#include "daemon/command/offline_commands.h"

namespace geond::daemon {

CommandResult Describe(const DescribeArguments& arguments, const CommandContext& context) {
  const Input input = ReadInput(arguments.input, arguments.unit);
  const ObjectModel model = BuildModelOf(input, arguments.options, context.stop, context.on_step);
  if (!arguments.picture.empty()) WritePng(ModelPicture(model), arguments.picture);
  return {Json::parse(ToJson(model.description)), ToText(model.description)};
}

CommandResult View(const ViewArguments& arguments, const CommandContext& context) {
  const Input input = ReadInput(arguments.input, arguments.unit);
  ObjectModel model;
  const bool needs_model = arguments.picture.panels != std::vector{Panel::kMesh};
  if (needs_model || !input.is_mesh()) {
    model = BuildModelOf(input, arguments.options, context.stop, context.on_step);
  } else {
    model.mesh = input.file.mesh;
  }
  if (context.on_step) context.on_step("draw", 0, 0);
  WritePng(ModelPicture(model, {}, arguments.picture), arguments.output);
  return {Json{{"picture", arguments.output.string()},
               {"columns", arguments.picture.columns},
               {"n_parts", model.segmentation.n_parts}},
          arguments.output.string() + " written"};
}

}  // namespace geond::daemon
