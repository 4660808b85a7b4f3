// SPDX-License-Identifier: Apache-2.0
// The quick run of every experiment against the figures recorded in tests/data/reproduce/quick.json: no figure may be worse
// than recorded by more than its own tolerance, unless it is nearer to the printed one. After a change that betters figures, or is meant to change them, record anew:
//   geon reproduce all --quick --data "" -o FOLDER && cp FOLDER/figures.json tests/data/reproduce/quick.json
#include <cmath>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "daemon/reproduce/report.h"

namespace geond::reproduce {

void PrintTo(const ExperimentEntry& entry, std::ostream* out) { *out << entry.name; }

namespace {

using Json = nlohmann::json;

Json Recorded(const std::string& name) {
  std::ifstream file(GEOND_TEST_DATA "/reproduce/quick.json");
  const Json all = Json::parse(file);
  for (const Json& experiment : all.at("experiments")) {
    if (experiment.at("name") == name) return experiment;
  }
  return {};
}

// Experiments whose repaired figures end on one run of annealing: the least change of the data sends it elsewhere, so they
// are reported and not held.
const std::set<std::string>& Annealed() {
  static const std::set<std::string> names{"table_1_1", "figure_5_11", "table_6_1", "table_6_2", "figure_6_22", "figure_6_25"};
  return names;
}

class FiguresTest : public testing::TestWithParam<ExperimentEntry> {};

TEST_P(FiguresTest, AreNoWorseThanRecorded) {
  reproduce::Run run;
  run.quick = true;
  run.threads = 1;
  const Experiment experiment = RunExperiment(GetParam(), run);
  EXPECT_FALSE(experiment.title.empty());
  EXPECT_FALSE(experiment.what.empty());
  EXPECT_FALSE(experiment.judgement.empty());
  ASSERT_FALSE(experiment.figures.empty());
  const Json recorded = Recorded(experiment.name);
  ASSERT_FALSE(recorded.is_null()) << experiment.name << " is not recorded";
  std::set<std::string> seen;
  for (const Figure& figure : experiment.figures) {
    EXPECT_TRUE(seen.insert(figure.key).second) << figure.key << " is there twice";
    const Json* of_figure = nullptr;
    for (const Json& one : recorded.at("figures")) {
      if (one.at("key") == figure.key) of_figure = &one;
    }
    ASSERT_NE(of_figure, nullptr) << experiment.name << "." << figure.key << " is not recorded";
    for (const auto& [column, now] : {std::pair("repaired", figure.repaired), std::pair("today", figure.today)}) {
      const Json& before = of_figure->at(column);
      if (before.is_null() || (column == std::string("repaired") && Annealed().contains(experiment.name))) continue;
      ASSERT_TRUE(now.has_value()) << experiment.name << "." << figure.key << " (" << column << ") is gone; recorded: " << before;
      const bool nearer = figure.thesis && std::abs(*now - *figure.thesis) <= std::abs(before.get<double>() - *figure.thesis);
      EXPECT_TRUE(nearer || !IsWorse(figure, before.get<double>(), *now))
          << experiment.name << "." << figure.key << " (" << column << "): " << figure.text << ": " << *now << " " << figure.unit
          << ", recorded " << before;
    }
  }
  EXPECT_EQ(seen.size(), recorded.at("figures").size()) << "a recorded figure is missing";
}

INSTANTIATE_TEST_SUITE_P(Thesis, FiguresTest, testing::ValuesIn(Experiments().begin(), Experiments().end()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(IsWorse, FollowsTheDirectionOfTheFigure) {
  Figure figure;
  figure.tolerance = 0.1;
  figure.better = Figure::Better::kLess;
  EXPECT_FALSE(IsWorse(figure, 1.0, 1.09));
  EXPECT_FALSE(IsWorse(figure, 1.0, 0.1));
  EXPECT_TRUE(IsWorse(figure, 1.0, 1.11));
  EXPECT_TRUE(IsWorse(figure, 1.0, std::numeric_limits<double>::quiet_NaN()));
  figure.better = Figure::Better::kMore;
  EXPECT_TRUE(IsWorse(figure, 1.0, 0.89));
  EXPECT_FALSE(IsWorse(figure, 1.0, 5.0));
  figure.better = Figure::Better::kSame;
  EXPECT_TRUE(IsWorse(figure, -1.0, -0.89));
  EXPECT_TRUE(IsWorse(figure, -1.0, -1.11));
  figure.slack = 0.2;
  EXPECT_FALSE(IsWorse(figure, -1.0, -1.29));
  figure.better = Figure::Better::kFree;
  EXPECT_FALSE(IsWorse(figure, 1.0, 100.0));
}

TEST(ExperimentByName, ListsTheNamesIfThereIsNone) {
  EXPECT_EQ(ExperimentByName("table_6_1").name, "table_6_1");
  try {
    ExperimentByName("table_7");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("figure_6_4"), std::string::npos) << error.what();
  }
}

TEST(RunExperiment, EndsWhenAskedTo) {
  std::stop_source stop;
  stop.request_stop();
  reproduce::Run run;
  run.stop = stop.get_token();
  for (const ExperimentEntry& entry : Experiments()) EXPECT_THROW(RunExperiment(entry, run), Cancelled) << entry.name;
}

}  // namespace
}  // namespace geond::reproduce
