// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <stop_token>
#include <string>
#include <vector>

namespace geond::daemon {

// Where a command line writes, and whether the error stream is a terminal (then progress is drawn on it).
struct Streams {
  std::ostream& out;
  std::ostream& err;
  bool err_is_terminal = false;
  int in_fd = -1;  // where a person answers questions; -1: nobody does
};

// Runs one command line of `geon` (without the program's name). Returns its exit code: 0 it worked, 1 the work failed, 2
// the command line is wrong; for the last two one sentence is on `err`. Throws nothing.
int RunGeon(const std::vector<std::string>& arguments, std::stop_token stop, Streams streams) noexcept;

}  // namespace geond::daemon
