// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "daemon/command/command.h"

// The commands of `geon` that talk to the service. JSON is what the socket answers. They throw RpcError as the service
// answers it, DeviceError if there is none, Cancelled.
namespace geond::daemon {

struct ServiceArguments {
  std::string socket;                // empty: where geond is by default
};

struct ScanArguments : ServiceArguments {
  std::optional<int> views;
  std::optional<int> resume;         // number of the scan to go on with
  std::string label;
  bool detach = false;               // do not wait for the description
  bool until_certain = false;        // scan with twice as many views until the description no longer changes
};
// Starts a scan, shows how it goes, ends with the description. Stopped while it waits, it cancels the scan. Until certain: the
// description also says `certain`, and `views_needed` (half of the last scan's), or null if it went on changing.
CommandResult Scan(const ScanArguments& arguments, const CommandContext& context);

CommandResult Status(const ServiceArguments& arguments, const CommandContext& context);
// Prints events as they come, a JSON object or a sentence a line, until stopped or the service ends.
struct WatchArguments : ServiceArguments {
  bool json_lines = false;
};
CommandResult Watch(const WatchArguments& arguments, const CommandContext& context);
CommandResult Cancel(const ServiceArguments& arguments, const CommandContext& context);
CommandResult Stop(const ServiceArguments& arguments, const CommandContext& context);
CommandResult Home(const ServiceArguments& arguments, const CommandContext& context);
CommandResult Reset(const ServiceArguments& arguments, const CommandContext& context);
CommandResult Scans(const ServiceArguments& arguments, const CommandContext& context);

struct ObjectsArguments : ServiceArguments {
  std::optional<int> scan;           // one object in full
};
CommandResult Objects(const ObjectsArguments& arguments, const CommandContext& context);

// Fetches a whole scan as a zip archive; takes one in.
struct ExportArguments : ServiceArguments {
  int scan = 0;
  std::string output;                // empty: scan_NUMBER.zip
};
CommandResult Export(const ExportArguments& arguments, const CommandContext& context);
struct ImportArguments : ServiceArguments {
  std::string file;
};
CommandResult Import(const ImportArguments& arguments, const CommandContext& context);
struct PinArguments : ServiceArguments {
  int scan = 0;
  bool off = false;
};
CommandResult Pin(const PinArguments& arguments, const CommandContext& context);
struct ScanNumberArguments : ServiceArguments {
  int scan = 0;
};
CommandResult Delete(const ScanNumberArguments& arguments, const CommandContext& context);
struct LogArguments : ServiceArguments {
  int limit = 50;
};
// The last lines of the service's log.
CommandResult LogLines(const LogArguments& arguments, const CommandContext& context);

struct ApiArguments : ServiceArguments {
  std::string method;                // to call; empty: list them
  std::string params;                // JSON
  bool markdown = false;             // list them as the reference page
};
CommandResult Api(const ApiArguments& arguments, const CommandContext& context);

// Looks at everything a scan needs and says what is wrong with it; fails if something is.
CommandResult Doctor(const ServiceArguments& arguments, const CommandContext& context);

}  // namespace geond::daemon
