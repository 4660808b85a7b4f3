// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/calibrate_command.h"
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

void AddCalibrate(CLI::App& app, ChosenCommand& chosen) {
  const auto arguments =
      Add(app, chosen, "calibrate", "Measure how the station stands, with two spheres of known diameter", &Calibrate);
  CLI::App* command = app.get_subcommand("calibrate");
  const auto diameter = [command](const std::string& name, double& meters, const std::string& help) {
    command->add_option_function<double>(name, [&meters](const double& mm) { meters = 1e-3 * mm; }, help)
        ->check(CLI::Range(5.0, 500.0));
  };
  diameter("--target-mm", arguments->target, "Diameter of the target sphere [40]");
  diameter("--check-mm", arguments->check, "Diameter of the check sphere, which the fit does not use [60]");
  command->add_option("--placements", arguments->placements, "Places the target is put to")->check(CLI::Range(2, 4));
  command->add_option("--views", arguments->views, "Range images a placement")->check(CLI::Range(4, 72));
  command->add_flag("--show", arguments->show, "Only say which calibration is in force");
  command->add_flag("--list", arguments->list, "Only list the calibrations there are");
  command->add_option("--use", arguments->use, "Go back to the calibration of this number; 0: the station as configured");
  command->add_option("--target", arguments->target_scans, "Recorded scans of the target, one a placement: no service needed");
  command->add_option("--check", arguments->check_scans, "Recorded scans of the check sphere");
  command->add_option("-o,--output", arguments->output, "Where the calibration from recorded scans goes");
}

}  // namespace

void AddServiceCommands(CLI::App& app, ChosenCommand& chosen) {
  AddCalibrate(app, chosen);
  const auto scan = Add(app, chosen, "scan", "Scan the object on the table and describe it", &Scan);
  CLI::App* command = app.get_subcommand("scan");
  command->add_option("--views", scan->views, "Range images, evenly round the table")->check(CLI::Range(1, 360));
  command->add_option("--label", scan->label, "What to call it");
  command->add_option("--resume", scan->resume, "Go on with the scan of this number")->check(CLI::Range(1, 1000000000));
  CLI::Option* detach = command->add_flag("--detach", scan->detach, "Only start it, do not wait");
  command->add_flag("--until-certain", scan->until_certain,
                    "Scan with twice as many views (from --views, else 4) until that changes nothing in the description")
      ->excludes(detach)
      ->excludes("--resume");

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
  const auto number = [&app](const char* name, int& given) {
    app.get_subcommand(name)->add_option("SCAN", given, "Number of the scan")->required()->check(CLI::Range(1, 1000000000));
  };
  const auto exported = Add(app, chosen, "export", "Fetch a whole scan as a zip archive", &Export);
  number("export", exported->scan);
  app.get_subcommand("export")->add_option("-o,--output", exported->output, "Where to; without it scan_NUMBER.zip");
  const auto imported = Add(app, chosen, "import", "Have geond take in a scan that was exported", &Import);
  app.get_subcommand("import")->add_option("FILE", imported->file, "The zip archive")->required();
  const auto pin = Add(app, chosen, "pin", "Keep a scan whatever its age and the space it takes", &Pin);
  number("pin", pin->scan);
  app.get_subcommand("pin")->add_flag("--off", pin->off, "No longer");
  const auto removed = Add(app, chosen, "delete", "Remove a scan and its files for good", &Delete);
  number("delete", removed->scan);
  const auto log = Add(app, chosen, "log", "The last lines of geond's log", &LogLines);
  app.get_subcommand("log")->add_option("-n,--lines", log->limit, "How many")->check(CLI::Range(1, 1000));
  const auto api = Add(app, chosen, "api", "The methods of the socket, or the answer of one", &Api);
  app.get_subcommand("api")->add_option("METHOD", api->method, "Method to call");
  app.get_subcommand("api")->add_option("PARAMS", api->params, "Its parameters, as JSON");
  app.get_subcommand("api")->add_flag("--markdown", api->markdown, "List them as the reference page of the manual");
  Add(app, chosen, "doctor", "Look for what would keep a scan from working", &Doctor);
}

}  // namespace geond::daemon
