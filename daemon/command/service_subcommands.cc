// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/service_commands.h"
#include "daemon/command/subcommands.h"

namespace geond::daemon {
namespace {

template <typename Arguments>
std::shared_ptr<Arguments> Add(CLI::App& app, ChosenCommand& chosen, const std::string& name, const std::string& help,
                               CommandResult (*run)(const Arguments&, const CommandContext&)) {
  CLI::App* command = AddCommand(app, name, help, chosen);
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--socket", arguments->socket, "Where geond is: path of its Unix socket, or host:port")
      ->envname("GEOND_SOCKET");
  command->callback([arguments, &chosen, run] {
    chosen.run = [arguments, run](const CommandContext& context) { return run(*arguments, context); };
  });
  return arguments;
}

}  // namespace

void AddServiceCommands(CLI::App& app, ChosenCommand& chosen) {
  const auto scan = Add(app, chosen, "scan", "Scan the object on the table and describe it", &Scan);
  CLI::App* command = app.get_subcommand("scan");
  command->add_option("--views", scan->views, "Range images, evenly round the table")->check(CLI::Range(1, 360));
  command->add_option("--label", scan->label, "What to call it");
  command->add_option("--resume", scan->resume, "Go on with the scan of this number")->check(CLI::Range(1, 1000000000));
  command->add_flag("--detach", scan->detach, "Only start it, do not wait");

  Add(app, chosen, "status", "What the station does, and how its devices are", &Status);
  const auto watch = Add(app, chosen, "watch", "Follow what happens; with --json an object a line", &Watch);
  app.get_subcommand("watch")->callback([watch, &chosen] {
    watch->json_lines = chosen.json;
    chosen.run = [watch](const CommandContext& context) { return Watch(*watch, context); };
    chosen.streams = true;
  });
  Add(app, chosen, "cancel", "End the scan that runs", &Cancel);
  Add(app, chosen, "stop", "Laser off and motion stopped, at once", &Stop);
  Add(app, chosen, "home", "Find the turntable's zero", &Home);
  Add(app, chosen, "reset", "Bring faulted devices back and allow motion again after a stop", &Reset);
  Add(app, chosen, "scans", "The scans that geond keeps", &Scans);
  const auto objects = Add(app, chosen, "objects", "The objects it has described", &Objects);
  app.get_subcommand("objects")->add_option("SCAN", objects->scan, "One of them in full");
  const auto api = Add(app, chosen, "api", "The methods of the socket, or the answer of one", &Api);
  app.get_subcommand("api")->add_option("METHOD", api->method, "Method to call");
  app.get_subcommand("api")->add_option("PARAMS", api->params, "Its parameters, as JSON");
  app.get_subcommand("api")->add_flag("--markdown", api->markdown, "List them as the reference page of the manual");
  Add(app, chosen, "doctor", "Look for what would keep a scan from working", &Doctor);
}

}  // namespace geond::daemon
