// SPDX-License-Identifier: Apache-2.0
#include "drivers/drive_profile.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

std::string Shipped(const std::string& name) { return std::string(GEOND_SOURCE_DIR) + "/config/drives/" + name; }

// A shipped profile with one piece of its text replaced, read again; what the complaint says.
std::string Complaint(const std::string& from, const std::string& to) {
  std::ifstream in(Shipped("oriental_blv_r.toml"));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "profile.toml";
  std::ofstream(path) << text;
  try {
    ReadDriveProfile(path);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(ReadDriveProfile, ReadsEveryShippedProfile) {
  int profiles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Shipped(""))) {
    const DriveProfile profile = ReadDriveProfile(entry.path());
    EXPECT_FALSE(profile.name.empty());
    EXPECT_NE(profile.moving, 0u);
    for (const char* name : {"enable", "home", "move", "stop", "quick_stop", "disable", "reset"}) {
      EXPECT_FALSE(profile.sequences.at(name).empty()) << entry.path() << " " << name;
    }
    ++profiles;
  }
  EXPECT_GE(profiles, 2);
}

TEST(ReadDriveProfile, SaysWhatTheManualSays) {
  const DriveProfile profile = ReadDriveProfile(Shipped("oriental_blv_r.toml"));
  EXPECT_EQ(profile.status.address, 0x007E);
  EXPECT_EQ(profile.position.address, 0x00CC);
  EXPECT_EQ(profile.position.type, DriveRegister::Type::kI32);
  EXPECT_EQ(profile.moving, 1u << 13);
  EXPECT_EQ(profile.communication_timeout.address, 0x138A);
  EXPECT_EQ(profile.alarm_words.at(0x85), "RS-485 communication timeout");
  EXPECT_EQ(profile.parity, 'E');
  const DriveStep& move = profile.sequences.at("move").at(0);
  EXPECT_EQ(move.address, 0x0058);
  int words = 0;
  for (const auto& [type, value] : move.values) words += DriveRegister{0, type}.words();
  EXPECT_EQ(words, 16) << "direct data and trigger go out as one block of 16 registers";
}

TEST(ReadDriveProfile, NamesFileLineAndKeyOfAMistake) {
  EXPECT_EQ(Complaint("baud = 230400", "baud = 230400"), "");
  for (const auto& [from, to, what] : std::vector<std::array<std::string, 3>>{
           {"baud = 230400", "baud = 7", "'baud' must be a number from"},
           {"word_order = \"high_first\"", "word_order = \"middle\"", "high_first, low_first"},
           {"moving = 13", "moving = 32", "'moving'"},
           {"alarmed = 7", "alarm = 7", "no key 'alarm'"},
           {"\"!alarmed\"", "\"!alarming\"", "no status bit is called 'alarming'"},
           {"[\"i32\", \"target\"]", "[\"i32\", \"goal\"]", "target, speed"},
           {"[\"i32\", \"target\"]", "[\"i64\", \"target\"]", "u16, i16, u32 or i32"},
           {"[[quick_stop]]", "[[quick_halt]]", "quick_halt"},
           {"name = \"Oriental", "name = Oriental", "profile.toml:2"}}) {
    const std::string complaint = Complaint(from, to);
    EXPECT_NE(complaint.find(what), std::string::npos) << to << " -> " << complaint;
    EXPECT_NE(complaint.find("profile.toml"), std::string::npos) << complaint;
  }
}

}  // namespace
}  // namespace geond::drivers
