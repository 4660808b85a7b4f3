// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/description_text.h"

namespace geond::daemon {

std::string DescriptionText(const Json& description) {
  std::string text = Format("%d part%s", description.at("n_parts").get<int>(), description.at("n_parts") == 1 ? "" : "s");
  for (const Json& part : description.at("parts")) {
    const Json& size = part.at("size_mm");
    const Json& at = part.at("pose").at("position_mm");
    text += Format("\n  %d %s, half sizes %.1f x %.1f x %.1f mm, at (%.1f, %.1f, %.1f) mm, residual %.2f mm, confidence %.0f %%",
                   part.at("id").get<int>(), part.at("type").get<std::string>().c_str(), size[0].get<double>(),
                   size[1].get<double>(), size[2].get<double>(), at[0].get<double>(), at[1].get<double>(), at[2].get<double>(),
                   part.at("residual_mm").get<double>(),
                   100.0 * (part.at("confidence").is_number() ? part.at("confidence").get<double>() : 0.0));
  }
  for (const Json& relation : description.at("relations")) {
    if (relation.contains("sentence")) text += "\n  " + relation["sentence"].get<std::string>();
  }
  return text;
}

}  // namespace geond::daemon
