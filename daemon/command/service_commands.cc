// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/service_commands.h"

#include "core/base/error.h"
#include "core/base/printed.h"
#include "daemon/command/description_change.h"
#include "daemon/command/description_text.h"
#include "daemon/command/service_client.h"

namespace geond::daemon {
namespace {

std::string Text(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

std::string Join(const Json& list) {
  std::string text;
  for (const Json& item : list) text += (text.empty() ? "" : ", ") + Text(item);
  return text;
}

std::string StatusText(const Json& status) {
  std::string text = "geond " + Text(status["version"]) + ", " + Text(status["station"]) + " station: " + Text(status["state"]);
  if (status["scan"].is_object()) {
    const Json& scan = status["scan"];
    text += Printed(", scan %d, view %d of %d, step %s", scan["scan"].get<int>(), scan["views_taken"].get<int>(),
                   scan["views"].get<int>(), Text(scan["step"]).c_str());
  }
  if (!Text(status["latched"]).empty()) text += "\nSTOPPED: " + Text(status["latched"]) + " (geon reset, once it is safe)";
  for (const Json& device : status["devices"]) {
    text += Printed("\n  %-12s %-7s %s %s", Text(device["name"]).c_str(), Text(device["state"]).c_str(),
                   Text(device["model"]).c_str(), Text(device["serial"]).c_str());
    if (!Text(device["fault"]).empty()) text += ": " + Text(device["fault"]);
  }
  text += Printed("\n  laser %s, motor %s", status["laser"].get<bool>() ? "ON" : "off", status["motor"].get<bool>() ? "ON" : "off");
  if (status["table_angle_deg"].is_number()) text += Printed(", table at %.2f degrees", status["table_angle_deg"].get<double>());
  if (status["emergency_stop"] == true) text += ", EMERGENCY STOP PRESSED";
  if (status["door_open"] == true) text += ", door open";
  return text;
}

CommandResult StatusResult(Json status) {
  std::string text = StatusText(status);
  return {std::move(status), std::move(text)};
}

std::string EventText(const Json& event) {
  const std::string kind = Text(event["event"]);
  if (kind == "state") return "station is " + Text(event["state"]);
  if (kind == "view") return Printed("view %d of %d", event["view"].get<int>() + 1, event["views"].get<int>());
  if (kind == "progress") {
    std::string text = Text(event["step"]);
    if (event["total"].get<int>() > 0) text += Printed(" %d/%d", event["done"].get<int>(), event["total"].get<int>());
    return text;
  }
  if (kind == "scan") {
    std::string text = Printed("scan %d %s", event["scan"].get<int>(), Text(event["state"]).c_str());
    if (event.contains("types")) text += ": " + Join(event["types"]);
    if (event.contains("error")) text += ": " + Text(event["error"]["message"]);
    return text;
  }
  if (kind == "lines") return Text(event["hazard"]).empty() ? "wires: nothing forbids work" : "wires: " + Text(event["hazard"]);
  return event.dump();
}

// Follows a scan to its end, on the progress bar.
Json Follow(ServiceClient& client, int scan, const CommandContext& context) {
  while (true) {
    const Json event = client.NextEvent();
    if (event.value("scan", 0) != scan) continue;
    if (event["event"] == "progress" && context.on_step) {
      context.on_step(Text(event["step"]), event["done"].get<int>(), event["total"].get<int>());
    }
    if (event["event"] != "scan" || event["state"] == "running") continue;
    if (event["state"] == "done") return client.Call("object.describe", {{"scan", scan}});
    if (event["state"] == "cancelled") throw Cancelled();
    const Json& error = event["error"];
    throw RpcError(static_cast<RpcError::Code>(error.value("code", -32603)), error.value("message", ""),
                   error["data"].value("remedy", ""));
  }
}

// Scans with twice as many views until that changes nothing that is described.
CommandResult ScanUntilCertain(ServiceClient& client, const ScanArguments& arguments, const CommandContext& context) {
  constexpr int kFirst = 4, kMost = 36;
  Json before;
  std::string history;
  for (int views = arguments.views.value_or(kFirst);; views *= 2) {
    Json params = {{"views", views}};
    if (!arguments.label.empty()) params["label"] = arguments.label;
    const int scan = client.Call("scan.start", params)["scan"].get<int>();
    Json description = Follow(client, scan, context);
    const std::string change = before.is_null() ? "" : WhatChanged(before, description);
    if (!before.is_null()) {
      history += Printed("%d views: %s\n", views, change.empty() ? "nothing new" : change.c_str());
    }
    const bool certain = !before.is_null() && change.empty();
    if (certain || (!before.is_null() && 2 * views > kMost)) {
      description["certain"] = certain;
      description["views_needed"] = certain ? Json(views / 2) : Json();
      const std::string words = certain ? Printed("%d views suffice", views / 2)
                                        : Printed("still changing at %d views: see the notes for what cannot be seen", views);
      std::string text = Printed("scan %d\n", scan) + history + words + "\n" + DescriptionText(description);
      return {std::move(description), std::move(text)};
    }
    before = std::move(description);
  }
}

}  // namespace

CommandResult Scan(const ScanArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  client.Call("events.subscribe");
  if (arguments.until_certain) {
    try {
      return ScanUntilCertain(client, arguments, context);
    } catch (const Cancelled&) {
      if (context.stop.stop_requested()) ServiceClient(client.address()).Call("scan.cancel");
      throw;
    }
  }
  Json params = Json::object();
  if (arguments.views) params["views"] = *arguments.views;
  if (!arguments.label.empty()) params["label"] = arguments.label;
  const Json begun = arguments.resume ? client.Call("scan.resume", {{"scan", *arguments.resume}})
                                      : client.Call("scan.start", params);
  const int scan = begun["scan"].get<int>();
  if (arguments.detach) return {begun, Printed("scan %d runs", scan)};
  try {
    Json description = Follow(client, scan, context);
    std::string text = DescriptionText(description);
    return {std::move(description), Printed("scan %d\n", scan) + text};
  } catch (const Cancelled&) {
    if (context.stop.stop_requested()) ServiceClient(client.address()).Call("scan.cancel");
    throw;
  }
}

CommandResult Status(const ServiceArguments& arguments, const CommandContext& context) {
  return StatusResult(ServiceClient(arguments.socket, context.stop).Call("station.status"));
}

CommandResult Watch(const WatchArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  client.Call("events.subscribe");
  int events = 0;
  try {
    while (true) {
      const Json event = client.NextEvent();
      ++events;
      context.say(arguments.json_lines ? event.dump() : EventText(event));
    }
  } catch (const Cancelled&) {
    return {};  // the way to end it
  }
}

CommandResult Cancel(const ServiceArguments& arguments, const CommandContext& context) {
  const Json result = ServiceClient(arguments.socket, context.stop).Call("scan.cancel");
  return {result, Printed("scan %d is being cancelled", result["scan"].get<int>())};
}

CommandResult Stop(const ServiceArguments& arguments, const CommandContext& context) {
  return StatusResult(ServiceClient(arguments.socket, context.stop).Call("station.stop"));
}

CommandResult Home(const ServiceArguments& arguments, const CommandContext& context) {
  return StatusResult(ServiceClient(arguments.socket, context.stop).Call("station.home"));
}

CommandResult Reset(const ServiceArguments& arguments, const CommandContext& context) {
  return StatusResult(ServiceClient(arguments.socket, context.stop).Call("station.reset"));
}

CommandResult Scans(const ServiceArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  CommandResult result;
  result.json["scans"] = Json::array();
  Json params = {{"limit", 1000}};
  while (true) {
    const Json page = client.Call("scan.list", params);
    for (const Json& scan : page["scans"]) result.json["scans"].push_back(scan);
    if (page["next"].is_null()) break;
    params["before"] = page["next"];
  }
  for (const Json& scan : result.json["scans"]) {
    if (!result.text.empty()) result.text += '\n';
    result.text += Printed("%6d %-11s %d/%d views  %s", scan["scan"].get<int>(), Text(scan["state"]).c_str(),
                          scan["views_taken"].get<int>(), scan["views"].get<int>(), Join(scan["types"]).c_str());
    if (!Text(scan["label"]).empty()) result.text += "  (" + Text(scan["label"]) + ")";
    if (!Text(scan["error"]).empty()) result.text += "  " + Text(scan["error"]);
  }
  if (result.text.empty()) result.text = "there are no scans yet";
  return result;
}

CommandResult Objects(const ObjectsArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  if (arguments.scan) {
    Json description = client.Call("object.describe", {{"scan", *arguments.scan}});
    std::string text = DescriptionText(description);
    return {std::move(description), std::move(text)};
  }
  CommandResult result;
  result.json = client.Call("object.list");
  for (const Json& object : result.json["objects"]) {
    if (!result.text.empty()) result.text += '\n';
    result.text += Printed("%6d  %s", object["scan"].get<int>(), Join(object["types"]).c_str());
    if (!Text(object["label"]).empty()) result.text += "  (" + Text(object["label"]) + ")";
  }
  if (result.text.empty()) result.text = "no object has been described yet";
  return result;
}

CommandResult Api(const ApiArguments& arguments, const CommandContext& context) {
  ServiceClient client(arguments.socket, context.stop);
  if (!arguments.method.empty()) {
    Json params = arguments.params.empty() ? Json::object() : Json::parse(arguments.params, nullptr, false);
    if (params.is_discarded()) throw std::invalid_argument("the parameters are not JSON: " + arguments.params);
    Json result = client.Call(arguments.method, params);
    std::string text = result.dump(2);
    return {std::move(result), std::move(text)};
  }
  CommandResult result;
  result.json = client.Call("rpc.discover");
  if (arguments.markdown) {
    result.text = ApiReference(result.json);
    return result;
  }
  for (const Json& method : result.json["methods"]) {
    std::string params;
    for (const Json& parameter : method["params"]) {
      const std::string name = Text(parameter["name"]);
      params += " " + (parameter["required"] == true ? name : "[" + name + "]");
    }
    result.text += Printed("%s%-36s %-6s %s", result.text.empty() ? "" : "\n", (Text(method["name"]) + params).c_str(),
                          Text(method["x-role"]).c_str(), Text(method["summary"]).c_str());
  }
  return result;
}

CommandResult Doctor(const ServiceArguments& arguments, const CommandContext& context) {
  CommandResult result;
  result.json = {{"healthy", true}, {"findings", Json::array()}};
  const auto find = [&](bool fine, const std::string& what, const std::string& remedy) {
    result.json["findings"].push_back({{"fine", fine}, {"what", what}, {"remedy", remedy}});
    if (!fine) result.json["healthy"] = false;
    result.text += std::string(result.text.empty() ? "" : "\n") + (fine ? "ok    " : "WRONG ") + what +
                   (remedy.empty() ? "" : ". " + remedy);
  };
  try {
    ServiceClient client(arguments.socket, context.stop);
    find(true, "geond answers at " + client.address(), "");
    const std::string version = Text(client.greeting()["params"]["version"]);
    find(version == GEOND_VERSION, "geond is version " + version + ", geon " + GEOND_VERSION,
         version == GEOND_VERSION ? "" : "Restart geond after an update");
    const Json status = client.Call("station.status");
    find(Text(status["latched"]).empty(), Text(status["latched"]).empty() ? "nothing is latched" : "stopped: " + Text(status["latched"]),
         Text(status["latched"]).empty() ? "" : "Remove the cause, then geon reset");
    for (const Json& device : status["devices"]) {
      const bool fine = device["state"] == "idle" || device["state"] == "armed";
      find(fine, Text(device["name"]) + " is " + Text(device["state"]) + (Text(device["fault"]).empty() ? "" : ": " + Text(device["fault"])),
           fine ? "" : Text(device["fault"]).empty() ? "Check power and cable, then geon reset" : "After that: geon reset");
    }
    find(status["emergency_stop"] == false, status["emergency_stop"] == false ? "the emergency stop is released" : "the emergency stop is pressed",
         status["emergency_stop"] == false ? "" : "Release it");
    find(status["door_open"] == false, status["door_open"] == false ? "the door is closed" : "the door is open",
         status["door_open"] == false ? "" : "Close it");
  } catch (const DeviceError& error) {
    find(false, error.thing() + ": " + error.call() + ": " + error.cause(), error.remedy());
  }
  result.exit_code = result.json["healthy"] == true ? 0 : 1;
  return result;
}

}  // namespace geond::daemon
