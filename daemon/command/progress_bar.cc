// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/progress_bar.h"

#include <algorithm>

#include "core/base/printed.h"
#include "daemon/command/command.h"

namespace geond::daemon {

void ProgressBar::Show(std::string_view step, int done, int total) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  const bool ends = total > 0 && done >= total;
  if (drawn_ && step == step_ && !ends && now - last_ < std::chrono::milliseconds(100)) return;
  step_ = step;
  last_ = now;
  drawn_ = true;
  std::string line = Printed("\r\033[K%-12s ", step_.c_str());
  if (total > 0) {
    constexpr int kWidth = 30;
    const int full = static_cast<int>(static_cast<long long>(std::clamp(done, 0, total)) * kWidth / total);
    line += "[" + std::string(full, '#') + std::string(kWidth - full, '.') + Printed("] %d/%d", done, total);
  } else {
    line += done > 0 ? Printed("... %d", done) : "...";
  }
  out_ << line << std::flush;
}

void ProgressBar::Clear() {
  if (drawn_) out_ << "\r\033[K" << std::flush;
  drawn_ = false;
}

}  // namespace geond::daemon
