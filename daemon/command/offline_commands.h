// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "calib/register_views.h"
#include "core/object_model.h"
#include "core/surface/remesh.h"
#include "daemon/command/command.h"
#include "core/picture/object_picture.h"
#include "sim/simulate_scan.h"

// The commands of `geon` that work on files and need no service. Each takes its arguments as plain values, does the work,
// and returns what to print; JSON keys are those of docs/command-line.md, which other programs rely on. All throw FileError
// for what is wrong with a file, std::invalid_argument for an argument that makes no sense, and Cancelled.
namespace geond::daemon {

struct DescribeArguments {
  std::filesystem::path input;
  std::filesystem::path picture;  // empty: none
  double unit = 0.001;            // m in a unit of the file
  ModelOptions options;
};
CommandResult Describe(const DescribeArguments& arguments, const CommandContext& context);

struct MeshArguments {
  std::filesystem::path input, output;
  double unit = 0.001;
  TessellateOptions options;
};
CommandResult Mesh(const MeshArguments& arguments, const CommandContext& context);

struct ChargeArguments {
  std::filesystem::path input, output;  // output may be empty
  double unit = 0.001;
  ChargeOptions options;
};
CommandResult Charge(const ChargeArguments& arguments, const CommandContext& context);

struct ContourArguments {
  std::filesystem::path input;
  double unit = 0.001;
};
CommandResult Contour(const ContourArguments& arguments, const CommandContext& context);

struct SegmentArguments {
  std::filesystem::path input, seg;  // seg may be empty
  double unit = 0.001;
  SegmentOptions options;
  ChargeOptions charge;
};
CommandResult Segment(const SegmentArguments& arguments, const CommandContext& context);

struct FitArguments {
  std::filesystem::path input;
  double unit = 0.001;
  FitOptions options;
};
CommandResult Fit(const FitArguments& arguments, const CommandContext& context);

struct RegisterArguments {
  std::filesystem::path input, output;  // output may be empty
  double unit = 0.001;
  calib::RegisterOptions options;
};
CommandResult Register(const RegisterArguments& arguments, const CommandContext& context);

struct MergeArguments {
  std::filesystem::path input, output;
  double unit = 0.001;                  // of the points written
  IntegrateOptions options;
};
CommandResult Merge(const MergeArguments& arguments, const CommandContext& context);

struct SimulateArguments {
  std::filesystem::path scene, output;
  sim::SimOptions options;
};
CommandResult Simulate(const SimulateArguments& arguments, const CommandContext& context);

struct ViewArguments {
  std::filesystem::path input, output;
  double unit = 0.001;
  ObjectPictureOptions picture;
  ModelOptions options;
};
CommandResult View(const ViewArguments& arguments, const CommandContext& context);

struct ReproduceArguments {
  std::string name = "all";                    // of an experiment, or all
  std::filesystem::path output = "reproduced"; // folder of the report
  std::filesystem::path data;                  // folder of real files; may be empty
  bool quick = false;
  int threads = 0;
};
CommandResult Reproduce(const ReproduceArguments& arguments, const CommandContext& context);

}  // namespace geond::daemon
