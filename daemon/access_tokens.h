// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/rpc.h"

namespace geond::daemon {

// Who may do what from another machine: a file of lines "ROLE TOKEN" (read, scan or admin; at least 16 letters), # begins a
// comment.
class AccessTokens {
 public:
  AccessTokens() = default;
  // Throws FileError if the file cannot be read or others than its owner and group can read it; ConfigError naming the
  // line for a role that does not exist or a token that is too short.
  explicit AccessTokens(const std::filesystem::path& path);

  bool empty() const { return entries_.empty(); }
  // The role of a token, kNone for an unknown one. Takes as long for a wrong token as for a right one.
  Role RoleOf(std::string_view token) const;

 private:
  struct Entry {
    Role role;
    std::string token;
  };
  std::vector<Entry> entries_;
};

}  // namespace geond::daemon
