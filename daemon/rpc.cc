// SPDX-License-Identifier: Apache-2.0
#include "daemon/rpc.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/error.h"
#include "daemon/nearest_name.h"

namespace geond::daemon {
namespace {

using Code = RpcError::Code;

bool HasType(const Json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "array") return value.is_array();
  return value.is_object();
}

void CheckParameter(const RpcParameter& parameter, const Json& value) {
  const std::string about = "parameter '" + parameter.name + "'";
  if (!HasType(value, parameter.type)) {
    throw RpcError(Code::kInvalidParams, about + " is not of type " + parameter.type, parameter.help);
  }
  if (value.is_number() && parameter.low < parameter.high) {
    const double number = value.get<double>();
    if (!(number >= parameter.low && number <= parameter.high)) {
      throw RpcError(Code::kInvalidParams, about + " is out of range",
                     "Allowed: " + Json(parameter.low).dump() + " to " + Json(parameter.high).dump());
    }
  }
  if (value.is_string() && !parameter.choices.empty() &&
      std::find(parameter.choices.begin(), parameter.choices.end(), value.get<std::string>()) == parameter.choices.end()) {
    std::string choices;
    for (const std::string& choice : parameter.choices) choices += (choices.empty() ? "" : ", ") + choice;
    throw RpcError(Code::kInvalidParams, about + " is none of its choices", "Allowed: " + choices);
  }
}

// Parameters by name, checked; a list is taken in the table's order.
Json CheckedParams(const RpcMethod& method, const Json& request) {
  Json params = Json::object();
  const Json given = request.contains("params") ? request["params"] : Json::object();
  if (given.is_array()) {
    if (given.size() > method.parameters.size()) {
      throw RpcError(Code::kInvalidParams, method.name + " takes at most " + std::to_string(method.parameters.size()) +
                                               " parameters");
    }
    for (std::size_t i = 0; i < given.size(); ++i) params[method.parameters[i].name] = given[i];
  } else if (given.is_object()) {
    params = given;
  } else {
    throw RpcError(Code::kInvalidRequest, "params is neither an object nor an array");
  }
  for (const auto& [name, value] : params.items()) {
    const auto known = std::find_if(method.parameters.begin(), method.parameters.end(),
                                    [&name = name](const RpcParameter& parameter) { return parameter.name == name; });
    if (known == method.parameters.end()) {
      std::vector<std::string> names;
      for (const RpcParameter& parameter : method.parameters) names.push_back(parameter.name);
      const std::string nearest = NearestName(name, names);
      throw RpcError(Code::kInvalidParams, method.name + " has no parameter '" + name + "'",
                     nearest.empty() ? "" : "Did you mean '" + nearest + "'?");
    }
    CheckParameter(*known, value);
  }
  for (const RpcParameter& parameter : method.parameters) {
    if (parameter.required && !params.contains(parameter.name)) {
      throw RpcError(Code::kInvalidParams, method.name + " needs the parameter '" + parameter.name + "'", parameter.help);
    }
  }
  return params;
}

std::string Response(const Json& id, const Answer& answer) {
  Json response = {{"jsonrpc", "2.0"}, {"id", id}};
  if (const Json* result = std::get_if<Json>(&answer)) {
    response["result"] = *result;
  } else {
    response["error"] = std::get<RpcError>(answer).ToJson();
  }
  return response.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json ParameterSchema(const RpcParameter& parameter) {
  Json schema = {{"type", parameter.type}};
  if (parameter.low < parameter.high) {
    schema["minimum"] = parameter.low;
    schema["maximum"] = parameter.high;
  }
  if (!parameter.choices.empty()) schema["enum"] = parameter.choices;
  return schema;
}

}  // namespace

Json RpcError::ToJson() const {
  return {{"code", static_cast<int>(code_)},
          {"message", what()},
          {"data", {{"name", RpcErrorName(code_)}, {"remedy", remedy_}}}};
}

RpcError ToRpcError(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const RpcError& error) {
    return error;
  } catch (const DeviceError& error) {
    return {Code::kDeviceFailed, error.thing() + ": " + error.call() + ": " + error.cause(), error.remedy()};
  } catch (const FileError& error) {
    return {Code::kStorage, error.thing() + ": " + error.call() + ": " + error.cause(), error.remedy()};
  } catch (const Cancelled&) {
    return {Code::kCancelled, "cancelled"};
  } catch (const std::exception& error) {
    return {Code::kInternal, error.what(), "See the log of geond"};
  }
}

std::string_view RpcErrorName(Code code) {
  switch (code) {
    case Code::kParse: return "parse";
    case Code::kInvalidRequest: return "invalid_request";
    case Code::kNoSuchMethod: return "no_such_method";
    case Code::kInvalidParams: return "invalid_params";
    case Code::kInternal: return "internal";
    case Code::kBusy: return "busy";
    case Code::kNotFound: return "not_found";
    case Code::kUnsafe: return "unsafe";
    case Code::kDeviceFailed: return "device_failed";
    case Code::kCancelled: return "cancelled";
    case Code::kForbidden: return "forbidden";
    case Code::kTooManyClients: return "too_many_clients";
    case Code::kUnavailable: return "unavailable";
    case Code::kStorage: return "storage";
    case Code::kTooLarge: return "too_large";
    case Code::kScanFailed: return "scan_failed";
    case Code::kRateLimited: return "rate_limited";
  }
  return "internal";
}

const std::vector<Code>& RpcErrorCodes() {
  static const std::vector<Code> codes = {
      Code::kParse, Code::kInvalidRequest, Code::kNoSuchMethod, Code::kInvalidParams, Code::kInternal, Code::kBusy,
      Code::kNotFound, Code::kUnsafe, Code::kDeviceFailed, Code::kCancelled, Code::kForbidden, Code::kTooManyClients,
      Code::kUnavailable, Code::kStorage, Code::kTooLarge, Code::kScanFailed,
      Code::kRateLimited};
  return codes;
}

std::string_view RoleName(Role role) {
  switch (role) {
    case Role::kNone: return "none";
    case Role::kRead: return "read";
    case Role::kScan: return "scan";
    case Role::kAdmin: return "admin";
  }
  return "none";
}

Json RequestId(std::string_view line) {
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object() || !request.contains("id")) return nullptr;
  const Json& id = request["id"];
  return id.is_number_integer() || id.is_string() ? id : Json();
}

Json RpcSchema(std::initializer_list<std::pair<const char*, const char*>> properties) {
  Json schema = {{"type", "object"}, {"properties", Json::object()}};
  for (const auto& [name, type] : properties) schema["properties"][name] = {{"type", type}};
  return schema;
}

RpcParameter ScanIdParameter(bool required) {
  return {"scan", "integer", required ? "Number of the scan" : "Number of the scan; without it the last one", required, 1,
          1e9, {}};
}

void RpcTable::Add(RpcMethod method) {
  if (Find(method.name)) throw std::invalid_argument("there is already a method " + method.name);
  methods_.push_back(std::move(method));
}

const RpcMethod* RpcTable::Find(std::string_view name) const {
  const auto found = std::find_if(methods_.begin(), methods_.end(), [&](const RpcMethod& m) { return m.name == name; });
  return found == methods_.end() ? nullptr : &*found;
}

void RpcTable::Handle(std::string_view line, Client& client, const std::function<void(std::string)>& respond) const {
  Json id = nullptr;
  bool wants_reply = true;
  try {
    const Json request = Json::parse(line, nullptr, false);
    if (request.is_discarded()) throw RpcError(Code::kParse, "the line is not JSON", "Send one JSON object a line");
    if (!request.is_object()) {
      throw RpcError(Code::kInvalidRequest, "the line is no JSON object", "Send one request a line, without batches");
    }
    if (request.contains("id")) {
      id = request["id"];
      if (!id.is_number_integer() && !id.is_string() && !id.is_null()) {
        id = nullptr;
        throw RpcError(Code::kInvalidRequest, "id is neither a whole number nor a string");
      }
    }
    if (request.value("jsonrpc", Json()) != "2.0" || !request.contains("method") || !request["method"].is_string()) {
      throw RpcError(Code::kInvalidRequest, "the request lacks jsonrpc \"2.0\" or a method",
                     R"(For example: {"jsonrpc":"2.0","id":1,"method":"station.status"})");
    }
    wants_reply = request.contains("id");
    const std::string name = request["method"].get<std::string>();
    const RpcMethod* method = Find(name);
    if (!method) {
      std::vector<std::string> names;
      for (const RpcMethod& known : methods_) names.push_back(known.name);
      const std::string nearest = NearestName(name, names);
      throw RpcError(Code::kNoSuchMethod, "there is no method '" + name + "'",
                     nearest.empty() ? "rpc.discover lists them all" : "Did you mean '" + nearest + "'?");
    }
    if (client.role < method->role) {
      throw RpcError(Code::kForbidden, name + " needs the role " + std::string(RoleName(method->role)),
                     "Log in with a token of that role (auth.login)");
    }
    method->run(CheckedParams(*method, request), client, [id, wants_reply, respond](const Answer& answer) {
      if (wants_reply) respond(Response(id, answer));
    });
  } catch (const std::exception&) {
    if (wants_reply) respond(Response(id, ToRpcError(std::current_exception())));
  }
}

Json RpcTable::Discover() const {
  Json methods = Json::array();
  for (const RpcMethod& method : methods_) {
    Json params = Json::array();
    for (const RpcParameter& parameter : method.parameters) {
      params.push_back({{"name", parameter.name},
                        {"description", parameter.help},
                        {"required", parameter.required},
                        {"schema", ParameterSchema(parameter)}});
    }
    methods.push_back({{"name", method.name},
                       {"summary", method.help},
                       {"params", std::move(params)},
                       {"result", {{"name", "result"}, {"schema", method.result}}},
                       {"x-role", RoleName(method.role)}});
  }
  Json errors = Json::array();
  for (const Code code : RpcErrorCodes()) {
    errors.push_back({{"code", static_cast<int>(code)}, {"message", RpcErrorName(code)}});
  }
  return {{"openrpc", "1.2.6"},
          {"info", {{"title", "geond"}, {"version", GEOND_VERSION}}},
          {"methods", std::move(methods)},
          {"x-errors", std::move(errors)}};
}

std::string ApiReference(const Json& document) {
  const auto text = [](const Json& value) { return value.get<std::string>(); };
  std::string page =
      "# The socket API of geond\n\n"
      "JSON-RPC 2.0, one object a line. The service greets each connection with a line that names its version. Events come\n"
      "as notifications named `event` once `events.subscribe` was called. Errors carry a stable code and name, a sentence, and what\n"
      "to do.\n\n## Over HTTP\n\n"
      "| request | answer |\n|---|---|\n"
      "| `POST /rpc` | the same methods, a request a body (`application/json`) |\n"
      "| `GET /ws` | a WebSocket: a request a message, answers and events as messages |\n"
      "| `GET /scans/7/NAME` | a file of a done scan, with Range and ETag: `description.json`, `grasps.json`, `cloud.ply`, `mesh.ply`, `picture.png`, `scan.json` and the range images it names |\n"
      "| `GET /scans/7.zip` | the whole scan |\n"
      "| `POST /scans` | takes in such an archive as a new scan (role admin) |\n"
      "| `GET /metrics` | counters and gauges for Prometheus |\n\n"
      "Where there are tokens: `Authorization: Bearer TOKEN`, or `auth.login` on a WebSocket or a TCP connection.\n\n## Methods\n";
  for (const Json& method : document.at("methods")) {
    page += "\n### " + text(method["name"]) + "\n\n" + text(method["summary"]) + " Role: " + text(method["x-role"]) + ".\n";
    if (!method["params"].empty()) page += "\n| parameter | type | | meaning |\n|---|---|---|---|\n";
    for (const Json& parameter : method["params"]) {
      page += "| `" + text(parameter["name"]) + "` | " + text(parameter["schema"]["type"]) + " | " +
              (parameter["required"] == true ? "required" : "optional") + " | " + text(parameter["description"]) + " |\n";
    }
    const Json& schema = method["result"]["schema"];
    if (!schema.contains("properties")) continue;
    page += "\nResult:";
    for (const auto& [name, unused] : schema["properties"].items()) page += " `" + name + "`";
    page += "\n";
  }
  page += "\n## Errors\n\n| code | name |\n|---|---|\n";
  for (const Json& error : document.at("x-errors")) page += "| " + error["code"].dump() + " | " + text(error["message"]) + " |\n";
  return page;
}

}  // namespace geond::daemon
