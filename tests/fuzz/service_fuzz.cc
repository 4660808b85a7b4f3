// SPDX-License-Identifier: Apache-2.0
// Whatever a client, a robot, a configuration or a stored file says: an answer or a named error, never a crash. The first
// byte chooses which of them it is.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/base/error.h"
#include "daemon/config.h"
#include "daemon/exposure_file.h"
#include "daemon/http_files.h"
#include "daemon/robot/allow_list.h"
#include "daemon/robot/robot_protocol.h"
#include "daemon/rpc.h"

namespace {

using namespace geond;
using namespace geond::daemon;

RpcTable Table() {
  RpcTable table;
  table.Add({"scan.start", Role::kScan,
             {{"views", "integer", "", false, 1, 360, {}}, {"label", "string", "", false, 0, 0, {"a", "b"}},
              {"angle", "number", "", true, -360, 360, {}}},
             {}, "", [](const Json& params, Client&, const Reply& reply) { reply(params); }});
  return table;
}

void Check(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 6) {
    case 0: {
      static const RpcTable table = Table();
      Client client;
      table.Handle(text, client, [](const std::string& answer) {
        const Json json = Json::parse(answer);  // throws if it is none
        Check(json.contains("result") != json.contains("error"));
      });
      break;
    }
    case 1: {
      const auto request = ParseRobotRequest(text);
      Check(!request || (request->number >= 0 && request->number <= 999 && text.size() <= kMaxRobotLine));
      break;
    }
    case 2:
      try {
        Check(ParseConfig(ConfigText(ParseConfig(text, "fuzz")), "again") == ParseConfig(text, "fuzz"));
      } catch (const ConfigError&) {
      }
      break;
    case 3:
      try {
        Check(EncodeExposure(DecodeExposure(text, "fuzz")) == text);
      } catch (const FileError&) {
      }
      break;
    case 4: {
      const auto range = ParseRange(text, 1000);
      Check(!range || range->first + range->length <= 1000);
      Check(!IsPlainPath(text) || text.find("..") != 0);
      IsLoopbackName(text);
      break;
    }
    default:
      try {
        AllowList(text).Contains(text);
      } catch (const std::invalid_argument&) {
      }
  }
  return 0;
}
