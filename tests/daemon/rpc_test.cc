// SPDX-License-Identifier: Apache-2.0
#include "daemon/rpc.h"

#include <optional>
#include <set>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond::daemon {
namespace {

RpcTable Table() {
  RpcTable table;
  table.Add({"sum.make", Role::kRead,
             {{"a", "integer", "First", true, 0, 100, {}}, {"b", "number", "Second", false, 0, 0, {}},
              {"how", "string", "How", false, 0, 0, {"fast", "well"}}},
             {{"type", "object"}, {"properties", {{"sum", {{"type", "number"}}}}}}, "Adds.",
             [](const Json& params, Client&, const Reply& reply) {
               reply(Json{{"sum", params["a"].get<int>() + params.value("b", 0.0)}});
             }});
  table.Add({"disk.fill", Role::kAdmin, {}, {}, "Fails.", [](const Json&, Client&, const Reply&) {
               throw FileError("/x", "write", "disk full", "Make room");
             }});
  return table;
}

// The answer to a line, or none.
std::optional<Json> Ask(const std::string& line, Role role = Role::kAdmin) {
  Client client;
  client.role = role;
  std::optional<Json> answer;
  Table().Handle(line, client, [&](const std::string& text) { answer = Json::parse(text); });
  return answer;
}

int CodeOf(const std::string& line) { return Ask(line)->at("error")["code"]; }

TEST(RpcTable, AnswersWithTheIdOfTheRequest) {
  const auto answer = Ask(R"({"jsonrpc":"2.0","id":"x7","method":"sum.make","params":{"a":2,"b":0.5}})");
  EXPECT_EQ(answer->dump(), R"({"jsonrpc":"2.0","id":"x7","result":{"sum":2.5}})");
  EXPECT_EQ((*Ask(R"({"jsonrpc":"2.0","id":3,"method":"sum.make","params":[2]})"))["result"]["sum"], 2.0);
}

TEST(RpcTable, KeepsSilentOnNotifications) {
  EXPECT_FALSE(Ask(R"({"jsonrpc":"2.0","method":"sum.make","params":{"a":2}})"));
  EXPECT_FALSE(Ask(R"({"jsonrpc":"2.0","method":"nothing.there"})"));
}

TEST(RpcTable, EachMistakeHasItsCode) {
  EXPECT_EQ(CodeOf("{"), -32700);
  EXPECT_EQ(CodeOf("\xff\xfe"), -32700);
  EXPECT_EQ(CodeOf("[]"), -32600);
  EXPECT_EQ(CodeOf("{}"), -32600);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"1.0","id":1,"method":"sum.make"})"), -32600);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":{},"method":"sum.make"})"), -32600);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.mkae"})"), -32601);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make"})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":{"a":101}})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":{"a":1.5}})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":{"a":1,"c":1}})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":{"a":1,"how":"badly"}})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":[1,2,"fast",4]})"), -32602);
  EXPECT_EQ(CodeOf(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":7})"), -32600);
}

TEST(RpcTable, ErrorsSayWhatToDo) {
  const Json error = Ask(R"({"jsonrpc":"2.0","id":1,"method":"disk.fill"})")->at("error");
  EXPECT_EQ(error["code"], 1009);
  EXPECT_EQ(error["data"]["name"], "storage");
  EXPECT_EQ(error["data"]["remedy"], "Make room");
  EXPECT_EQ((*Ask(R"({"jsonrpc":"2.0","id":1,"method":"sum.mkae"})"))["error"]["data"]["remedy"], "Did you mean 'sum.make'?");
}

TEST(RpcTable, RolesAreHeld) {
  EXPECT_EQ((*Ask(R"({"jsonrpc":"2.0","id":1,"method":"disk.fill"})", Role::kScan))["error"]["data"]["name"], "forbidden");
  EXPECT_EQ((*Ask(R"({"jsonrpc":"2.0","id":1,"method":"sum.make","params":[1]})", Role::kNone))["error"]["code"], 1006);
}

TEST(RpcTable, DiscoveryAndReferenceListEveryMethodAndParameter) {
  const RpcTable table = Table();
  const Json document = table.Discover();
  EXPECT_EQ(document["methods"].size(), 2u);
  EXPECT_EQ(document["methods"][0]["params"][0]["schema"]["maximum"], 100.0);
  const std::string reference = ApiReference(document);
  for (const RpcMethod& method : table.methods()) {
    EXPECT_NE(reference.find("### " + method.name), std::string::npos);
    for (const RpcParameter& parameter : method.parameters) EXPECT_NE(reference.find("`" + parameter.name + "`"), std::string::npos);
  }
}

TEST(RpcTable, RefusesAMethodTwice) {
  RpcTable table = Table();
  EXPECT_THROW(table.Add({"sum.make", Role::kRead, {}, {}, "", {}}), std::invalid_argument);
}

TEST(RpcError, CodesAndNamesAreOneToOne) {
  std::set<std::string_view> names;
  for (const RpcError::Code code : RpcErrorCodes()) EXPECT_TRUE(names.insert(RpcErrorName(code)).second);
}

}  // namespace
}  // namespace geond::daemon
