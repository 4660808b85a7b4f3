// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/description_text.h"

#include "core/base/printed.h"

namespace geond::daemon {

std::string DescriptionText(const Json& description) {
  std::string text = Printed("%d part%s", description.at("n_parts").get<int>(), description.at("n_parts") == 1 ? "" : "s");
  for (const Json& part : description.at("parts")) {
    const Json& size = part.at("size_mm");
    const Json& at = part.at("pose").at("position_mm");
    // An older service does not say which sizes are only what was seen.
    const auto half_size = [&](std::size_t k) {
      const bool least = part.contains("size_at_least") && part["size_at_least"][k].get<bool>();
      return Printed("%s%.1f", least ? "at least " : "", size[k].get<double>());
    };
    text += Printed("\n  %d %s, half sizes %s x %s x %s mm, at (%.1f, %.1f, %.1f) mm, residual %.2f mm, confidence %.0f %%",
                   part.at("id").get<int>(), part.at("type").get<std::string>().c_str(), half_size(0).c_str(),
                   half_size(1).c_str(), half_size(2).c_str(), at[0].get<double>(), at[1].get<double>(), at[2].get<double>(),
                   part.at("residual_mm").get<double>(),
                   100.0 * (part.at("confidence").is_number() ? part.at("confidence").get<double>() : 0.0));
  }
  for (const Json& relation : description.at("relations")) {
    if (relation.contains("sentence")) text += "\n  " + relation["sentence"].get<std::string>();
  }
  return text;
}

}  // namespace geond::daemon
