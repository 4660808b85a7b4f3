// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <numbers>

#include "daemon/command/offline_commands.h"
#include "daemon/command/subcommands.h"
#include "daemon/reproduce/experiment.h"

namespace geond::daemon {
namespace {

namespace fs = std::filesystem;

template <typename Value>
CLI::CheckedTransformer OneOf(const std::map<std::string, Value>& names) {
  return CLI::CheckedTransformer(names);
}

void AddUnit(CLI::App* command, double& unit) {
  command
      ->add_option_function<std::string>(
          "--unit", [&unit](const std::string& name) { unit = MetersPerUnit(name); },
          "Unit of coordinates in files that have none: mm, cm, m or in")
      ->check(CLI::IsMember(std::vector<std::string>{"mm", "cm", "m", "in"}))
      ->default_str("mm");
}

// An option in millimetres for a value in metres.
void AddMillimeters(CLI::App* command, const std::string& name, double& meters, const std::string& help) {
  command
      ->add_option_function<double>(name, [&meters](const double& millimeters) { meters = 1e-3 * millimeters; }, help)
      ->check(CLI::PositiveNumber);
}

void AddDegrees(CLI::App* command, const std::string& name, double& radians, const std::string& help) {
  command->add_option_function<double>(
      name, [&radians](const double& degrees) { radians = degrees * std::numbers::pi / 180.0; }, help);
}

void AddThreads(CLI::App* command, int& threads) {
  command->add_option("--threads", threads, "Threads to use; 0: all processors. The result is the same")
      ->check(CLI::Range(0, 1024));
}

void AddMethod(CLI::App* command, SegmentOptions& options) {
  using Method = SegmentOptions::Method;
  command->add_option("--method", options.method, "How to cut: watershed, trace or threshold")
      ->transform(OneOf<Method>(
          {{"watershed", Method::kWatershed}, {"trace", Method::kTrace}, {"threshold", Method::kThreshold}}))
      ->default_str("watershed");
  command->add_option("--detail", options.detail, "How weak a concavity still cuts: 0 coarse to 1 fine")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
}

void AddSolver(CLI::App* command, ChargeOptions& options) {
  using Solver = ChargeOptions::Solver;
  command->add_option("--solver", options.solver, "auto, dense (exact, up to some thousands of triangles) or fast")
      ->transform(OneOf<Solver>({{"auto", Solver::kAuto}, {"dense", Solver::kDense}, {"fast", Solver::kFast}}))
      ->default_str("auto");
  command->add_option("--tolerance", options.tolerance, "Greatest rms error of the density, relative to its mean")
      ->check(CLI::Range(1e-12, 0.5))
      ->capture_default_str();
}

void AddModelOptions(CLI::App* command, ModelOptions& options) {
  command->add_option("--triangles", options.tessellate.triangles, "Wanted number of triangles of the mesh")
      ->check(CLI::Range(100, 2000000))
      ->capture_default_str();
  AddMethod(command, options.segment);
  command->add_option("--seed", options.fit.seed, "Of the generator of random starts")->capture_default_str();
  command
      ->add_option_function<int>(
          "--threads",
          [&options](const int& threads) {
            options.integrate.threads = options.tessellate.threads = options.charge.threads = options.fit.threads =
                threads;
          },
          "Threads to use; 0: all processors. The result is the same")
      ->check(CLI::Range(0, 1024));
}

template <typename Arguments>
std::shared_ptr<Arguments> Choose(CLI::App* command, ChosenCommand& chosen,
                                  CommandResult (*run)(const Arguments&, const CommandContext&)) {
  auto arguments = std::make_shared<Arguments>();
  command->callback([arguments, &chosen, run] {
    chosen.run = [arguments, run](const CommandContext& context) { return run(*arguments, context); };
  });
  return arguments;
}

void AddDescribe(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "describe", "Say which geons an object is made of", chosen);
  const auto arguments = Choose(command, chosen, &Describe);
  command->add_option("INPUT", arguments->input, "Mesh, cloud or folder of a recorded scan")->required();
  command->add_option("--picture", arguments->picture, "Also draw what was found, as a PNG");
  AddUnit(command, arguments->unit);
  AddModelOptions(command, arguments->options);
}

void AddMesh(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "mesh", "Make one closed mesh", chosen);
  const auto arguments = Choose(command, chosen, &Mesh);
  command->add_option("INPUT", arguments->input, "Mesh, cloud or folder of a recorded scan")->required();
  command->add_option("-o,--output", arguments->output, "Mesh to write: .ply, .off, .obj or .stl")->required();
  command->add_option("--triangles", arguments->options.triangles, "Wanted number of triangles")
      ->check(CLI::Range(20, 5000000))
      ->capture_default_str();
  AddMillimeters(command, "--edge", arguments->options.edge_length, "Wanted length of the edges, mm (else --triangles)");
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->options.threads);
}

void AddCharge(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "charge", "Charge density on a conductor of a mesh's shape", chosen);
  const auto arguments = Choose(command, chosen, &Charge);
  command->add_option("MESH", arguments->input, "Mesh file")->required();
  command->add_option("-o,--output", arguments->output, "PLY with the density as a property of its faces");
  AddSolver(command, arguments->options);
  command->add_flag("--one-sign", arguments->options.one_sign,
                    "Make densities 0 that come out negative beside creases; their neighbours bear them");
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->options.threads);
}

void AddContour(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "contour", "Charge density on a closed polygon in the plane", chosen);
  const auto arguments = Choose(command, chosen, &Contour);
  command->add_option("FILE", arguments->input, "Two columns, x and y of a corner a line")->required();
  AddUnit(command, arguments->unit);
}

void AddSegment(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "segment", "Cut a closed mesh into parts", chosen);
  const auto arguments = Choose(command, chosen, &Segment);
  command->add_option("MESH", arguments->input, "Mesh file")->required();
  command->add_option("--seg", arguments->seg, "Also write the labels, one a line");
  AddMethod(command, arguments->options);
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->charge.threads);
}

void AddFit(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "fit", "Fit geons to the points of one part", chosen);
  const auto arguments = Choose(command, chosen, &Fit);
  command->add_option("CLOUD", arguments->input, "Cloud with normals, or mesh")->required();
  std::vector<std::string> names = {"all"};
  for (const GeonType type : kGeonTypes) names.emplace_back(GeonTypeName(type));
  command
      ->add_option_function<std::string>(
          "--model",
          [arguments](const std::string& name) {
            if (name != "all") arguments->options.types = {GeonTypeFromName(name)};
          },
          "One type by name, or all")
      ->check(CLI::IsMember(names))
      ->default_str("all");
  using Optimizer = FitOptions::Optimizer;
  command->add_option("--optimizer", arguments->options.optimizer, "multistart, or vfsr (annealing)")
      ->transform(OneOf<Optimizer>({{"multistart", Optimizer::kMultiStart}, {"vfsr", Optimizer::kVfsr}}))
      ->default_str("multistart");
  command->add_flag("--thorough", arguments->options.thorough,
                    "Search some ten times as long, for the least objective of types that the points are not of, too");
  command->add_option("--seed", arguments->options.seed, "Of the generator of random starts")->capture_default_str();
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->options.threads);
}

void AddRegister(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "register", "Refine the views of a recorded scan", chosen);
  const auto arguments = Choose(command, chosen, &Register);
  command->add_option("SCAN", arguments->input, "Folder of the scan")->required();
  command->add_option("-o,--output", arguments->output, "Folder to write the scan to, with refined poses");
  using Model = calib::RegisterOptions::Model;
  command->add_option("--model", arguments->options.model, "auto, turntable (one axis) or free (six degrees a view)")
      ->transform(OneOf<Model>({{"auto", Model::kAuto}, {"turntable", Model::kTurntable}, {"free", Model::kFree}}))
      ->default_str("auto");
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->options.threads);
}

void AddMerge(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "merge", "One cloud with normals from all views of a recorded scan", chosen);
  const auto arguments = Choose(command, chosen, &Merge);
  command->add_option("SCAN", arguments->input, "Folder of the scan")->required();
  command->add_option("-o,--output", arguments->output, "Cloud to write: .ply, .pcd or .xyz")->required();
  AddMillimeters(command, "--distance", arguments->options.distance, "Data of two views closer than this are one, mm");
  AddUnit(command, arguments->unit);
  AddThreads(command, arguments->options.threads);
}

void AddSimulate(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "simulate", "Record a scan of a virtual object, with the truth beside it", chosen);
  const auto arguments = Choose(command, chosen, &Simulate);
  command->add_option("SCENE", arguments->scene, "Scene file (.toml)")->required();
  command->add_option("-o,--output", arguments->output, "Folder to write the scan to")->required();
  command->add_option("--views", arguments->options.views, "Range images, evenly round the table")
      ->check(CLI::Range(1, 360))
      ->capture_default_str();
  command->add_option("--columns", arguments->options.columns, "Pixels a row")->check(CLI::Range(16, 4096))
      ->capture_default_str();
  command->add_option("--rows", arguments->options.rows, "Rows an image")->check(CLI::Range(16, 4096))
      ->capture_default_str();
  AddMillimeters(command, "--distance-mm", arguments->options.distance, "From the sensor to the middle of the object");
  AddDegrees(command, "--elevation-deg", arguments->options.elevation, "Of the sensor over the plane of the table");
  command
      ->add_option_function<double>(
          "--noise-mm", [arguments](const double& noise) { arguments->options.depth_noise = 1e-3 * noise; },
          "Standard deviation of depth, straight on, at 450 mm")
      ->check(CLI::Range(0.0, 50.0));
  command->add_option("--seed", arguments->options.seed, "Of the noise")->capture_default_str();
  AddThreads(command, arguments->options.threads);
}

void AddView(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "view", "Draw an object and what was found, without a display", chosen);
  const auto arguments = Choose(command, chosen, &View);
  command->add_option("INPUT", arguments->input, "Mesh, cloud or folder of a recorded scan")->required();
  command->add_option("-o,--output", arguments->output, "PNG to write")->required();
  command->add_option_function<std::vector<std::string>>(
      "--show",
      [arguments](const std::vector<std::string>& names) {
        arguments->picture.panels.clear();
        for (const std::string& name : names) {
          try {
            arguments->picture.panels.push_back(PanelFromName(name));
          } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError("--show", error.what());
          }
        }
      },
      "Any of cloud, mesh, charge, parts, geons (default: all there is)");
  command->add_option("--width", arguments->picture.columns, "Pixels")->check(CLI::Range(16, 8192))
      ->capture_default_str();
  command->add_option("--height", arguments->picture.rows, "Pixels; 0: what suits")->check(CLI::Range(0, 8192))
      ->capture_default_str();
  AddDegrees(command, "--azimuth-deg", arguments->picture.azimuth, "Where the eye is, from +x counter-clockwise");
  AddDegrees(command, "--elevation-deg", arguments->picture.elevation, "Where the eye is, above the horizon");
  AddUnit(command, arguments->unit);
  AddModelOptions(command, arguments->options);
}

void AddReproduce(CLI::App& app, ChosenCommand& chosen) {
  CLI::App* command = AddCommand(app, "reproduce", "Run the experiments of the thesis again and write a report", chosen);
  const auto arguments = Choose(command, chosen, &Reproduce);
  std::vector<std::string> names = {"all"};
  for (const reproduce::ExperimentEntry& entry : reproduce::Experiments()) names.emplace_back(entry.name);
  command->add_option("NAME", arguments->name, "One experiment, or all")->check(CLI::IsMember(names))->default_str("all");
  command->add_option("-o,--output", arguments->output, "Folder for report.html and figures.json")->default_str("reproduced");
  command->add_option("--data", arguments->data, "Folder of real files to measure too")->envname("GEOND_DATA");
  command->add_flag("--quick", arguments->quick, "Fewer objects, seeds and sizes");
  AddThreads(command, arguments->threads);
}

}  // namespace

void AddOfflineCommands(CLI::App& app, ChosenCommand& chosen) {
  AddDescribe(app, chosen);
  AddMesh(app, chosen);
  AddCharge(app, chosen);
  AddContour(app, chosen);
  AddSegment(app, chosen);
  AddFit(app, chosen);
  AddRegister(app, chosen);
  AddMerge(app, chosen);
  AddSimulate(app, chosen);
  AddView(app, chosen);
  AddReproduce(app, chosen);
}

}  // namespace geond::daemon
