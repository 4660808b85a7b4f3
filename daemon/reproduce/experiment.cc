// SPDX-License-Identifier: Apache-2.0
#include "daemon/reproduce/experiment.h"

#include <chrono>
#include <cmath>
#include <stdexcept>

#include "daemon/reproduce/experiments.h"

namespace geond::reproduce {

void Run::Progress(std::string_view experiment, int done, int total) const {
  ThrowIfStopped(stop);
  if (on_step) on_step(experiment, done, total);
}

bool Figure::bar_met() const {
  if (!has_bar()) return true;
  return better == Better::kMore ? *today >= *bar : *today <= *bar;
}

bool IsWorse(const Figure& figure, double recorded, double now) {
  const double allowed = figure.tolerance * std::abs(recorded) + figure.slack;
  switch (figure.better) {
    case Figure::Better::kLess: return !(now <= recorded + allowed);
    case Figure::Better::kMore: return !(now >= recorded - allowed);
    case Figure::Better::kSame: return !(std::abs(now - recorded) <= allowed);
    case Figure::Better::kFree: return false;
  }
  return false;
}

std::span<const ExperimentEntry> Experiments() {
  static constexpr ExperimentEntry kAll[] = {
      {"table_1_1", &PinTable},
      {"figure_4_3", &EdgeLaw},
      {"figure_5_11", &AnnealingTrace},
      {"figure_6_4", &Ellipse},
      {"figure_6_5", &Cycloids},
      {"figure_6_7", &ContourNoise},
      {"figure_6_8", &WigglyDumbbell},
      {"figure_6_9", &PartSignificance},
      {"figure_6_15", &SolidObjects},
      {"figure_c_3", &InvisibleSide},
      {"table_6_1", &GeonTable},
      {"table_6_2", &BananaTable},
      {"figure_6_22", &BananaViews},
      {"figure_6_25", &MultiPartObjects},
      {"timing", &Timing},
      {"peers", &Peers},
  };
  return kAll;
}

const ExperimentEntry& ExperimentByName(std::string_view name) {
  std::string names;
  for (const ExperimentEntry& entry : Experiments()) {
    if (entry.name == name) return entry;
    names += (names.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no such experiment: '" + std::string(name) + "'; there are all, " + names);
}

Experiment RunExperiment(const ExperimentEntry& entry, const Run& run) {
  const auto begin = std::chrono::steady_clock::now();
  run.Progress(entry.name, 0, 0);
  Experiment experiment = entry.run(run);
  experiment.name = entry.name;
  experiment.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return experiment;
}

}  // namespace geond::reproduce
