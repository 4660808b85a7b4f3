// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/progress.h"
#include "core/geometry/pose.h"

namespace geond::daemon {

using Json = nlohmann::ordered_json;

// What a command of `geon` needs besides its arguments.
struct CommandContext {
  std::stop_token stop;
  StepObserver on_step;
  std::function<void(const std::string& line)> say;  // prints a line at once, for commands that speak while they run
  // Shows a question on the error stream and waits for Enter; false if nobody can answer, or when stopped.
  std::function<bool(const std::string& question)> ask;
};

// What a command has to say: `json` is printed with --json, `text` without it. Neither ends with a newline.
struct CommandResult {
  Json json;
  std::string text;
  int exit_code = 0;
};

// Metres in one `unit`: "mm", "m", "cm" or "in". Throws std::invalid_argument, listing the units, for another.
double MetersPerUnit(const std::string& unit);

// {position_mm [3], quaternion {w, x, y, z}}: w >= 0.
Json PoseJson(const Pose& pose);

// Wall time since it was made, s.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace geond::daemon
