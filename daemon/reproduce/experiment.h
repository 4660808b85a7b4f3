// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/picture/image.h"
#include "daemon/reproduce/plot.h"

// The experiments of Kenong Wu's thesis (McGill University, 1996), run again: beside each printed figure that of the
// thesis' own algorithm as repaired, and that of today's default.
namespace geond::reproduce {

// How an experiment is run.
struct Run {
  bool quick = false;           // fewer objects, seeds and sizes: what the tests run
  int threads = 0;              // 0: all processors; no figure but times depends on it
  std::filesystem::path data;   // folder of real files; empty or absent: what needs them is left out
  std::stop_token stop;
  StepObserver on_step;         // step: name of the experiment

  // Tells how far the experiment is, and throws Cancelled if the work is to end.
  void Progress(std::string_view experiment, int done, int total) const;
};

// One number and what the thesis printed for it.
struct Figure {
  enum class Better { kLess, kMore, kSame, kFree };  // kFree: no judgement (times depend on the machine)
  std::string key;                  // its name in the JSON, of the experiment
  std::string text;                 // what it is, for a person
  std::string unit;                 // "" for counts and ratios
  std::optional<double> thesis;     // as printed, or as the theory of the thesis has it
  std::optional<double> repaired;   // the thesis' algorithm with its errors corrected
  std::optional<double> today;      // the default
  Better better = Better::kFree;
  double tolerance = 0.1;           // by this share of its recorded value a number may get worse before a test fails,
  double slack = 0.0;               // and by this much in its own unit
  std::optional<double> bar;        // `today` is to be this or better

  bool has_bar() const { return bar && today; }
  bool bar_met() const;
};

// True if `now` is worse than `recorded` by more than the figure's tolerance and slack.
bool IsWorse(const Figure& figure, double recorded, double now);

struct Table {
  std::string caption;
  std::vector<std::string> heads;
  std::vector<std::vector<std::string>> rows;      // the first cell is the row's name; a cell that begins with * is
                                                   // drawn bold, without it
};

struct Picture {
  std::string caption;
  Image image;
};

struct Experiment {
  std::string name;                  // as on the command line
  std::string title;                 // with the numbers of the thesis
  std::string what;                  // what was done, on what data
  std::vector<Figure> figures;
  std::vector<Table> tables;
  std::vector<Plot> plots;
  std::vector<Outline> outlines;
  std::vector<Picture> pictures;
  std::string judgement;             // one honest sentence
  double seconds = 0.0;              // wall time
};

// An experiment that can be asked for.
struct ExperimentEntry {
  std::string_view name;
  Experiment (*run)(const Run& run);
};

// All of them, in the order of the report.
std::span<const ExperimentEntry> Experiments();
// Throws std::invalid_argument, listing the names, if there is none of that name.
const ExperimentEntry& ExperimentByName(std::string_view name);

// Runs one and takes its time.
Experiment RunExperiment(const ExperimentEntry& entry, const Run& run);

}  // namespace geond::reproduce
