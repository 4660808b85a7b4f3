// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "daemon/reproduce/experiment.h"

namespace geond::reproduce {

// {version, quick, bars, bars_met, experiments[] {name, title, what, judgement, seconds, figures[] {key, text, unit, thesis,
// repaired, today, better, tolerance, slack, bar, bar_met}, tables[]}}: absent numbers are null.
nlohmann::ordered_json ReportJson(const std::vector<Experiment>& experiments, bool quick);

// One page that needs nothing else: plots as SVG, pictures as PNG within it.
std::string ReportHtml(const std::vector<Experiment>& experiments, bool quick);

// Writes report.html and figures.json to a folder, made if absent. Throws FileError.
void WriteReport(const std::vector<Experiment>& experiments, bool quick, const std::filesystem::path& folder);

}  // namespace geond::reproduce
