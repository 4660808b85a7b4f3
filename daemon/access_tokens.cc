// SPDX-License-Identifier: Apache-2.0
#include "daemon/access_tokens.h"

#include <algorithm>
#include <sstream>

#include "core/base/error.h"
#include "daemon/durable_file.h"

namespace geond::daemon {
namespace {

constexpr std::size_t kLeastLetters = 16;

// Compares without stopping at the first difference; the length of `known` does not show either.
bool SameToken(std::string_view given, std::string_view known) {
  unsigned difference = given.size() == known.size() ? 0 : 1;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const char other = known.empty() ? '\0' : known[i % known.size()];
    difference |= static_cast<unsigned char>(given[i]) ^ static_cast<unsigned char>(other);
  }
  return difference == 0;
}

}  // namespace

AccessTokens::AccessTokens(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  std::istringstream lines(ReadWhole(path, 1 << 20));
  const fs::perms mode = fs::status(path).permissions();
  if ((mode & (fs::perms::others_all | fs::perms::group_write)) != fs::perms::none) {
    throw FileError(path.string(), "check", "others can read or change it", "Run chmod 640 on it");
  }
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string role, token, more;
    if (!(words >> role)) continue;
    const auto fail = [&](const std::string& cause) {
      throw ConfigError(path.string() + ":" + std::to_string(number), "token", cause,
                        "Write ROLE TOKEN, with a role of read, scan or admin");
    };
    if (!(words >> token) || words >> more) fail("the line is not a role and a token");
    if (token.size() < kLeastLetters) fail("the token has fewer than " + std::to_string(kLeastLetters) + " letters");
    Entry entry{Role::kNone, token};
    for (const Role each : {Role::kRead, Role::kScan, Role::kAdmin}) {
      if (RoleName(each) == role) entry.role = each;
    }
    if (entry.role == Role::kNone) fail("there is no role '" + role + "'");
    entries_.push_back(std::move(entry));
  }
  if (entries_.empty()) throw ConfigError(path.string(), "token", "there is none in it", "Write a line ROLE TOKEN");
}

Role AccessTokens::RoleOf(std::string_view token) const {
  Role role = Role::kNone;
  for (const Entry& entry : entries_) {
    if (SameToken(token, entry.token)) role = std::max(role, entry.role);
  }
  return role;
}

}  // namespace geond::daemon
