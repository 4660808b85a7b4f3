// SPDX-License-Identifier: Apache-2.0
#include "core/base/printed.h"
#include "daemon/command/offline_commands.h"
#include "daemon/reproduce/report.h"

namespace geond::daemon {

CommandResult Reproduce(const ReproduceArguments& arguments, const CommandContext& context) {
  using reproduce::ExperimentEntry;
  std::vector<ExperimentEntry> chosen;
  if (arguments.name == "all") {
    chosen.assign(reproduce::Experiments().begin(), reproduce::Experiments().end());
  } else {
    chosen.push_back(reproduce::ExperimentByName(arguments.name));
  }
  reproduce::Run run;
  run.quick = arguments.quick;
  run.threads = arguments.threads;
  run.data = arguments.data;
  run.stop = context.stop;
  run.on_step = context.on_step;
  std::vector<reproduce::Experiment> experiments;
  for (const ExperimentEntry& entry : chosen) experiments.push_back(reproduce::RunExperiment(entry, run));
  reproduce::WriteReport(experiments, arguments.quick, arguments.output);

  CommandResult result;
  result.json = reproduce::ReportJson(experiments, arguments.quick);
  for (const reproduce::Experiment& experiment : experiments) {
    result.text += Printed("%s (%.1f s)\n", experiment.title.c_str(), experiment.seconds);
    for (const reproduce::Figure& figure : experiment.figures) {
      if (!figure.has_bar()) continue;
      result.text += Printed("  %-4s %s: %.4g%s%s, bar %.4g\n", figure.bar_met() ? "met" : "MISS", figure.text.c_str(), *figure.today,
                            figure.unit.empty() ? "" : " ", figure.unit.c_str(), *figure.bar);
    }
    result.text += "  " + experiment.judgement + "\n";
  }
  result.text += "The report is " + (arguments.output / "report.html").string() + ", every figure in " +
                 (arguments.output / "figures.json").string();
  return result;
}

}  // namespace geond::daemon
