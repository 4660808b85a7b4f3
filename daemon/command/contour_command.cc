// SPDX-License-Identifier: Apache-2.0
#include "core/base/printed.h"
#include "core/charge/contour.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "daemon/command/offline_commands.h"

namespace geond::daemon {
namespace {

// Two columns a line, x and y, parted by blanks or a comma; what follows a # does not count.
std::vector<Eigen::Vector2d> ReadPolygon(const std::filesystem::path& path, double meters_per_unit) {
  std::ifstream file(path);
  if (!file) throw FileError(path.string(), "open", "it cannot be read", "Check the path");
  std::vector<Eigen::Vector2d> polygon;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line.resize(std::min(line.size(), line.find('#')));
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream columns(line);
    double x = 0.0, y = 0.0;
    std::string rest;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    if (!(columns >> x >> y) || columns >> rest) {
      throw FileError(path.string(), "read", "line " + std::to_string(number) + " is not two numbers",
                      "Give x and y of one corner a line");
    }
    polygon.emplace_back(meters_per_unit * x, meters_per_unit * y);
  }
  if (!file.eof()) throw FileError(path.string(), "read", "it cannot be read", "Check that it is a text file");
  return polygon;
}

}  // namespace

CommandResult Contour(const ContourArguments& arguments, const CommandContext& context) {
  const std::vector<Eigen::Vector2d> polygon = ReadPolygon(arguments.input, arguments.unit);
  ContourDensity charge;
  try {
    charge = SolveContourCharge(polygon, {}, context.stop, context.on_step);
  } catch (const std::invalid_argument& error) {
    throw FileError(arguments.input.string(), "contour", error.what());
  }
  for (double& density : charge.density) density *= 1e-3;  // 1/m to 1/mm
  for (double& density : charge.segment_density) density *= 1e-3;
  const auto [least, greatest] = std::minmax_element(charge.density.begin(), charge.density.end());
  const std::size_t n = charge.density.size();
  CommandResult result;
  result.text = Printed("%zu corners, density %.4g to %.4g /mm%s", n, *least, *greatest,
                       charge.summary.converged ? "" : ("; NOT CONVERGED: " + charge.summary.message).c_str());
  result.json = {{"n", n},
                 {"converged", charge.summary.converged},
                 {"residual", charge.summary.residual},
                 {"error_estimate", charge.error_estimate},
                 {"seconds", charge.summary.seconds},
                 {"density", std::move(charge.density)},
                 {"segment_density", std::move(charge.segment_density)}};
  return result;
}

}  // namespace geond::daemon
