// SPDX-License-Identifier: Apache-2.0
// Whatever line a client says: an answer or a named error.
#include <cstdint>
#include <string>

#include "daemon/rpc.h"
#include "tests/fuzz/check.h"

namespace {

using namespace geond::daemon;

RpcTable Table() {
  RpcTable table;
  table.Add({"scan.start",
             Role::kScan,
             {{"views", "integer", "", false, 1, 360, {}},
              {"label", "string", "", false, 0, 0, {"a", "b"}},
              {"angle", "number", "", true, -360, 360, {}}},
             {},
             "",
             [](const Json& params, Client&, const Reply& reply) { reply(params); }});
  return table;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const RpcTable table = Table();
  Client client;
  table.Handle(std::string(reinterpret_cast<const char*>(data), size), client, [](const std::string& answer) {
    const Json json = Json::parse(answer);  // throws if it is none
    Check(json.contains("result") != json.contains("error"));
  });
  return 0;
}
