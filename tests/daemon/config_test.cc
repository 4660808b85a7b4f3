// SPDX-License-Identifier: Apache-2.0
#include "daemon/config.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "daemon/nearest_name.h"

namespace geond::daemon {
namespace {

using testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  try {
    ParseConfig(text, "geond.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Config, TheFileInTheHouseDocumentsTheDefaults) {
  std::ifstream file(std::string(GEOND_SOURCE_DIR) + "/config/geond.toml");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), ConfigText({}));
  EXPECT_EQ(ParseConfig(text.str(), "geond.toml"), Config{});
}

TEST(Config, TextAndValuesRoundTrip) {
  Config config;
  config.scan_views = 12;
  config.scan_detail = 0.125;
  config.scan_picture = false;
  config.store_folder = "/tmp/a \"b\" \\c";
  config.api_port = 0;
  EXPECT_EQ(ParseConfig(ConfigText(config), "x"), config);
}

TEST(Config, EveryKeyHasASentenceAndItsDefaultIsAllowed) {
  for (const ConfigKey& key : ConfigKeys()) {
    EXPECT_GT(key.sentence.size(), 12u) << key.name;
    EXPECT_EQ(key.sentence.back(), '.') << key.name;
  }
}

TEST(Config, MistakesNameFileLineAndKey) {
  EXPECT_THAT(ErrorOf("[scan]\n\nvews = 8\n"), HasSubstr("geond.toml:3: scan.vews"));
  EXPECT_THAT(ErrorOf("[scan]\n\nvews = 8\n"), HasSubstr("scan.views"));
  EXPECT_THAT(ErrorOf("[scan]\nviews = 0\n"), HasSubstr("geond.toml:2: scan.views: 0 is out of range. Allowed: 1 to 360"));
  EXPECT_THAT(ErrorOf("[scan]\nviews = 8.5\n"), HasSubstr("not a whole number"));
  EXPECT_THAT(ErrorOf("[scan]\nviews = \"8\"\n"), HasSubstr("not a whole number"));
  EXPECT_THAT(ErrorOf("[scan]\npicture = 1\n"), HasSubstr("true or false"));
  EXPECT_THAT(ErrorOf("[station]\nkind = \"simulation\"\n"), HasSubstr("Did you mean 'simulated'"));
  EXPECT_THAT(ErrorOf("[station]\nkind = 3\n"), HasSubstr("quotes"));
  EXPECT_THAT(ErrorOf("[scna]\nviews = 3\n"), HasSubstr("scan.views"));
  EXPECT_THAT(ErrorOf("views = 3\n"), HasSubstr("no such key"));
  EXPECT_THAT(ErrorOf("[scan]\nviews = = 3\n"), HasSubstr("geond.toml:2"));
  EXPECT_THAT(ErrorOf("[scan]\ndetail = nan\n"), HasSubstr("out of range"));
  EXPECT_THAT(ErrorOf("[store]\nfolder = \"\"\n"), HasSubstr("store.folder"));
}

TEST(Config, KeysAreSetFromTheCommandLine) {
  Config config;
  SetConfigKey(config, "scan.views=5");
  SetConfigKey(config, "api.unix_socket=/tmp/x y.sock");
  SetConfigKey(config, "scan.picture=false");
  SetConfigKey(config, "api.unix_socket=");
  EXPECT_EQ(config.scan_views, 5);
  EXPECT_EQ(config.api_unix_socket, "");
  EXPECT_FALSE(config.scan_picture);
  for (const char* wrong : {"scan.views", "views=3", "scan.views=", "scan.views=x", "scan.views=999", "=", ""}) {
    EXPECT_THROW(SetConfigKey(config, wrong), ConfigError) << wrong;
  }
}

TEST(Config, ChangedKeysAreThoseThatDiffer) {
  Config config;
  config.scan_views = 9;
  const auto changed = ChangedKeys({}, config);
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(changed[0]->name, "scan.views");
  EXPECT_TRUE(changed[0]->reloadable);
}

TEST(NearestName, IsTheOneThatWasMeant) {
  const std::vector<std::string> names = {"station.kind", "scan.views", "scan.detail"};
  EXPECT_EQ(NearestName("scan.veiws", names), "scan.views");
  EXPECT_EQ(NearestName("scan.views", names), "scan.views");
  EXPECT_EQ(NearestName("something.entirely_else", names), "");
  EXPECT_EQ(EditDistance("ab", "ba"), 1);
  EXPECT_EQ(EditDistance("", "abc"), 3);
}

}  // namespace
}  // namespace geond::daemon
