// SPDX-License-Identifier: Apache-2.0
#include "daemon/command/command_line.h"

#include <algorithm>

#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "daemon/command/progress_bar.h"
#include "daemon/command/subcommands.h"

namespace geond::daemon {
namespace {

int Fail(std::ostream& err, const std::string& sentence) {
  err << "geon: " << sentence << std::endl;
  return 1;
}

// One line of a text that may have several.
std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// Reads one line from a file descriptor, waking now and then to see whether the work is to stop.
bool WaitForEnter(int fd, const std::stop_token& stop) {
  constexpr int kWakeMs = 200;
  while (fd >= 0 && !stop.stop_requested()) {
    pollfd waited{fd, POLLIN, 0};
    if (poll(&waited, 1, kWakeMs) <= 0) continue;
    char letter = 0;
    if (read(fd, &letter, 1) != 1) return false;
    if (letter == '\n') return true;
  }
  return false;
}

int RunChosen(const ChosenCommand& chosen, std::stop_token stop, Streams streams) {
  ProgressBar bar(streams.err, streams.err_is_terminal);
  CommandContext context;
  context.stop = stop;
  context.on_step = [&](std::string_view step, int done, int total) { bar.Show(step, done, total); };
  context.say = [&](const std::string& line) {
    bar.Clear();
    streams.out << line << std::endl;
  };
  context.ask = [&](const std::string& question) {
    bar.Clear();
    streams.err << question << std::flush;
    return WaitForEnter(streams.in_fd, stop);
  };
  try {
    const CommandResult result = chosen.run(context);
    bar.Clear();
    if (chosen.streams) {
      // nothing is left to say
    } else if (chosen.json) {
      streams.out << result.json.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
    } else if (!result.text.empty()) {
      streams.out << result.text << (result.text.back() == '\n' ? "" : "\n");
    }
    streams.out.flush();
    if (!streams.out) return Fail(streams.err, "standard output cannot be written");
    return result.exit_code;
  } catch (const Cancelled&) {
    bar.Clear();
    return Fail(streams.err, "cancelled");
  } catch (const std::bad_alloc&) {
    bar.Clear();
    return Fail(streams.err, "out of memory: give fewer triangles or points");
  } catch (const std::exception& error) {
    bar.Clear();
    return Fail(streams.err, OneLine(error.what()));
  }
}

}  // namespace

CLI::App* AddCommand(CLI::App& app, const std::string& name, const std::string& help, ChosenCommand& chosen) {
  CLI::App* command = app.add_subcommand(name, help);
  command->add_flag("--json", chosen.json, "Print one JSON object on standard output and nothing else");
  return command;
}

int RunGeon(const std::vector<std::string>& arguments, std::stop_token stop, Streams streams) noexcept {
  try {
    CLI::App app("geon: from scanned objects to parametric parts, on files and with the service geond", "geon");
    app.set_version_flag("--version", std::string("geon ") + GEOND_VERSION);
    app.require_subcommand(1);
    app.get_formatter()->column_width(34);
    ChosenCommand chosen;
    AddOfflineCommands(app, chosen);
    AddServiceCommands(app, chosen);
    try {
      app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::CallForHelp& help) {
      return app.exit(help, streams.out, streams.err);
    } catch (const CLI::CallForAllHelp& help) {
      return app.exit(help, streams.out, streams.err);
    } catch (const CLI::CallForVersion& version) {
      return app.exit(version, streams.out, streams.err);
    } catch (const CLI::ParseError& error) {
      const std::vector<CLI::App*> given = app.get_subcommands();
      streams.err << "geon: " << OneLine(error.what()) << " (see geon "
                  << (given.empty() ? "" : given.front()->get_name() + " ") << "--help)" << std::endl;
      return 2;
    }
    return RunChosen(chosen, stop, streams);
  } catch (const std::exception& error) {
    return Fail(streams.err, error.what());
  }
}

}  // namespace geond::daemon
