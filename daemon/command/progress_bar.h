// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <ostream>
#include <string>
#include <string_view>

namespace geond::daemon {

// A line on a terminal that is drawn over again as work goes on, at most ten times a second. Lives on one thread.
class ProgressBar {
 public:
  // Draws on `out`, or nothing at all if `enabled` is false.
  ProgressBar(std::ostream& out, bool enabled) : out_(out), enabled_(enabled) {}
  ~ProgressBar() { Clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // As a StepObserver.
  void Show(std::string_view step, int done, int total);
  // Wipes the line, so that something else can be written.
  void Clear();

 private:
  std::ostream& out_;
  bool enabled_;
  bool drawn_ = false;
  std::string step_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace geond::daemon
