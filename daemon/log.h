// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <spdlog/spdlog.h>

namespace geond::daemon {

// What a line of the log is about; journald keeps it in fields of its own (GEOND_SCAN, GEOND_DEVICE, GEOND_STEP).
struct LogSubject {
  int scan = 0;        // 0: none
  std::string device;  // empty: none
  std::string step;    // empty: none
};

// Sends the log of the whole program to journald where the service manager has connected it, else to standard error;
// the last lines are kept for LogTail.
void OpenLog(const std::string& level);

// A line about something. Safe from any thread.
void Log(spdlog::level::level_enum level, const LogSubject& subject, const std::string& sentence);

// The last lines, oldest first, at most `limit` (1000 are kept); none before OpenLog. Safe from any thread.
std::vector<std::string> LogTail(std::size_t limit);

}  // namespace geond::daemon
