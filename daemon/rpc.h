// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "daemon/rate_limit.h"

// JSON-RPC 2.0, one object a line: the table of methods, and what becomes of a line.
namespace geond::daemon {

using Json = nlohmann::ordered_json;

// What went wrong with a request: stable code and name for programs, a sentence and what to do for people.
class RpcError : public std::runtime_error {
 public:
  enum class Code {
    kParse = -32700, kInvalidRequest = -32600, kNoSuchMethod = -32601, kInvalidParams = -32602, kInternal = -32603,
    kBusy = 1001, kNotFound = 1002, kUnsafe = 1003, kDeviceFailed = 1004, kCancelled = 1005, kForbidden = 1006,
    kTooManyClients = 1007, kUnavailable = 1008, kStorage = 1009, kTooLarge = 1010, kScanFailed = 1011,
    kRateLimited = 1012,
  };
  RpcError(Code code, const std::string& sentence, std::string remedy = {})
      : std::runtime_error(sentence), code_(code), remedy_(std::move(remedy)) {}

  Code code() const { return code_; }
  const std::string& remedy() const { return remedy_; }
  // {code, message, data {name, remedy}}
  Json ToJson() const;

 private:
  Code code_;
  std::string remedy_;
};
// "busy", "not_found", ...: for programs, never changed.
std::string_view RpcErrorName(RpcError::Code code);
// What a client is told of an exception.
RpcError ToRpcError(const std::exception_ptr& failure);
// All codes, in order.
const std::vector<RpcError::Code>& RpcErrorCodes();

// Who may call a method; each may do what those before it may.
enum class Role { kNone, kRead, kScan, kAdmin };
std::string_view RoleName(Role role);  // "none", "read", "scan", "admin"

// One end of a connection, as methods see it. Lives on the I/O thread.
struct Client {
  std::uint64_t id = 0;
  Role role = Role::kAdmin;
  bool subscribed = false;
  std::function<void(std::string line)> send;  // without the newline; empty for a request that stands alone (HTTP)
  RateLimit rate;
  int wrong_logins = 0;
};

using Answer = std::variant<Json, RpcError>;
using Reply = std::function<void(Answer answer)>;  // to be called once, on the I/O thread

struct RpcParameter {
  std::string name;
  std::string type;          // of JSON Schema: "integer", "number", "string", "boolean", "array"
  std::string help;
  bool required = false;
  double low = 0.0, high = 0.0;  // of a number, if low < high
  std::vector<std::string> choices;  // of a string, if any
};

// The schema of an object with these properties; and the number of a scan as a parameter, by default the last.
Json RpcSchema(std::initializer_list<std::pair<const char*, const char*>> properties);
RpcParameter ScanIdParameter(bool required);

struct RpcMethod {
  std::string name;          // "scan.start"
  Role role = Role::kRead;
  std::vector<RpcParameter> parameters;
  Json result;               // JSON Schema
  std::string help;          // one sentence
  // May answer at once or later; may throw RpcError instead. `params` has been checked against `parameters`.
  std::function<void(const Json& params, Client& client, const Reply& reply)> run;
};

// The id of a request, null if it has none that could be answered to.
Json RequestId(std::string_view line);

// All methods: dispatch, discovery and reference come from this one table.
class RpcTable {
 public:
  // Throws std::invalid_argument if the name is taken.
  void Add(RpcMethod method);
  const std::vector<RpcMethod>& methods() const { return methods_; }
  const RpcMethod* Find(std::string_view name) const;

  // Answers one line: `respond` gets the response (without a newline), once, now or later; or never, for a notification.
  void Handle(std::string_view line, Client& client, const std::function<void(std::string)>& respond) const;

  // An OpenRPC document.
  Json Discover() const;

 private:
  std::vector<RpcMethod> methods_;
};

// The reference for people, in Markdown, of a document that Discover made.
std::string ApiReference(const Json& document);

}  // namespace geond::daemon
