// SPDX-License-Identifier: Apache-2.0
#include "core/base/printed.h"
#include "sim/simulate_scan.h"

#include "daemon/command/offline_commands.h"

namespace geond::daemon {

CommandResult Simulate(const SimulateArguments& arguments, const CommandContext& context) {
  const Stopwatch watch;
  const sim::Scene scene = sim::ReadScene(arguments.scene);
  const RecordedScan scan = sim::SimulateScan(scene, arguments.options, context.stop, context.on_step);
  WriteScan(scan, arguments.output);
  Json truth = scan.truth.empty() ? Json() : Json::parse(scan.truth);
  return {Json{{"n_views", scan.views.size()},
               {"truth", std::move(truth)},
               {"seed", scan.seed},
               {"scan", arguments.output.string()},
               {"seconds", watch.seconds()}},
          Printed("%zu views of %s in %s", scan.views.size(), scene.name.c_str(), arguments.output.c_str())};
}

}  // namespace geond::daemon
