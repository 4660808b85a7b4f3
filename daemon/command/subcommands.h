// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "daemon/command/command.h"

namespace geond::daemon {

// What the command line chose: set by the callback of the subcommand that was given.
struct ChosenCommand {
  std::function<CommandResult(const CommandContext&)> run;
  bool json = false;     // --json
  bool streams = false;  // the command has said everything itself
};

// Adds the subcommands that work on files.
void AddOfflineCommands(CLI::App& app, ChosenCommand& chosen);
// Adds the subcommands that talk to the service.
void AddServiceCommands(CLI::App& app, ChosenCommand& chosen);

// A subcommand with --json.
CLI::App* AddCommand(CLI::App& app, const std::string& name, const std::string& help, ChosenCommand& chosen);

}  // namespace geond::daemon
