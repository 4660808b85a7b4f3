// SPDX-License-Identifier: Apache-2.0
// The floors of the house, held by reading the #include lines of the sources themselves.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

// A room and those it may include (besides itself).
const std::map<std::string, std::set<std::string>>& AllowedIncludes() {
  static const std::map<std::string, std::set<std::string>> allowed = [] {
    std::map<std::string, std::set<std::string>> table{
        {"core/base", {}},
        {"core/geometry", {"core/base"}},
        {"core/range", {"core/base", "core/geometry"}},
        {"core/surface", {"core/base", "core/geometry", "core/range"}},
        {"core/charge", {"core/base", "core/geometry"}},
        {"core/parts", {"core/base", "core/geometry", "core/charge"}},
        {"core/geon", {"core/base", "core/geometry"}},
        {"core/describe", {"core/base", "core/geometry", "core/charge", "core/parts", "core/geon"}},
        {"core/picture", {"core/base", "core/geometry"}},
    };
    std::set<std::string> core{"core"};
    for (const auto& [room, unused] : table) core.insert(room);
    table["core"] = core;
    table["drivers"] = {"core/base", "core/geometry", "core/range"};
    table["calib"] = core;
    table["sim"] = core;
    table["sim"].insert("drivers");
    table["daemon/reproduce"] = core;
    table["daemon/reproduce"].insert({"sim", "calib"});
    table["daemon"] = table["sim"];
    table["daemon"].insert({"sim", "calib", "daemon/reproduce"});
    return table;
  }();
  return allowed;
}

std::string RoomOf(const fs::path& relative) {
  std::string room = relative.parent_path().generic_string();
  while (!room.empty() && !AllowedIncludes().contains(room)) room = fs::path(room).parent_path().generic_string();
  return room;
}

template <typename OnSource>
void ForEachSource(const OnSource& on_source) {
  const fs::path top = GEOND_SOURCE_DIR;
  for (const char* folder : {"core", "drivers", "calib", "sim", "daemon"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top / folder)) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".h" || ending == ".cc") on_source(fs::relative(entry.path(), top));
    }
  }
}

TEST(House, EachRoomIncludesOnlyRoomsBelowIt) {
  const std::regex include(R"re(^\s*#include "([^"]+)")re");
  int seen = 0;
  ForEachSource([&](const fs::path& source) {
    const std::string room = RoomOf(source);
    std::ifstream file(fs::path(GEOND_SOURCE_DIR) / source);
    for (std::string line; std::getline(file, line);) {
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      ++seen;
      const std::string target = RoomOf(match[1].str());
      EXPECT_FALSE(target.empty()) << source << " includes " << match[1] << " by a path that is not from the root";
      EXPECT_TRUE(target == room || AllowedIncludes().at(room).contains(target)) << source << " may not include " << match[1];
    }
  });
  EXPECT_GT(seen, 50);
}

TEST(House, NoSourceIsLongerThan400Lines) {
  ForEachSource([](const fs::path& source) {
    std::ifstream file(fs::path(GEOND_SOURCE_DIR) / source);
    int lines = 0;
    for (std::string line; std::getline(file, line);) ++lines;
    EXPECT_LE(lines, 400) << source << " wants splitting";
  });
}

TEST(House, EachSourceNamesItsLicence) {
  ForEachSource([](const fs::path& source) {
    std::ifstream file(fs::path(GEOND_SOURCE_DIR) / source);
    std::string line;
    std::getline(file, line);
    EXPECT_EQ(line, "// SPDX-License-Identifier: Apache-2.0") << source;
  });
}

}  // namespace
