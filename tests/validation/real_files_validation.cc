// SPDX-License-Identifier: Apache-2.0
// Every mesh, cloud and scan of other people through the whole line: real_files_validation [FOLDER...], default all of the
// folder GEOND_DATA (or ../shared/data). Prints a row a file: parts, types, residuals as a share of the object's size,
// seconds; or the one sentence why not. With GEOND_PICTURES=FOLDER a picture of each goes there.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "calib/conf_scan.h"
#include "calib/make_view.h"
#include "calib/register_views.h"
#include "core/geometry/mesh_files.h"
#include "core/model_picture.h"
#include "core/object_model.h"

namespace geond {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kEndings = {".ply", ".off", ".obj", ".stl", ".pcd", ".xyz", ".conf"};

ObjectModel ModelOf(const fs::path& path) {
  if (path.extension() == ".conf") {
    std::vector<RangeView> views = calib::MakeViews(calib::ReadConfScan(path));
    const calib::RegistrationResult registered = calib::RegisterViews(views);
    for (std::size_t i = 0; i < views.size(); ++i) views[i].X_TS = registered.X_TS[i];
    ModelOptions options;
    options.tessellate.close_on_table = false;
    return BuildObjectModel(views, options);
  }
  const GeometryFile file = ReadGeometry(path);
  return file.has_faces() ? BuildObjectModel(file.mesh) : BuildObjectModel(file.cloud);
}

void PrintRow(const fs::path& path, const std::string& name) {
  try {
    const ObjectModel model = ModelOf(path);
    double seconds = 0.0;
    for (const auto& [step, time] : model.description.seconds) seconds += time;
    const double size = BoundingBox(model.cloud.points).diagonal().norm();
    std::printf("%-44s %5.1f s %2zu parts ", name.c_str(), seconds, model.description.parts.size());
    for (const DescribedPart& part : model.description.parts) {
      std::printf(" %s %.4f;", std::string(GeonTypeName(part.geon().type)).c_str(), part.fits.front().residual / size);
    }
    for (const std::string& note : model.description.notes) std::printf(" [%s]", note.c_str());
    std::printf("\n");
    if (const char* folder = std::getenv("GEOND_PICTURES")) {
      WritePng(ModelPicture(model, name), fs::path(folder) / (path.parent_path().filename().string() + "_" + path.stem().string() + ".png"));
    }
  } catch (const std::exception& refusal) {
    std::printf("%-44s refused: %s\n", name.c_str(), refusal.what());
  }
  std::fflush(stdout);
}

int Run(int argc, char** argv) {
  std::vector<fs::path> folders(argv + 1, argv + argc);
  if (folders.empty()) {
    const char* named = std::getenv("GEOND_DATA");
    folders.push_back(named ? fs::path(named) : fs::path(GEOND_SOURCE_DIR) / "../shared/data");
  }
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    if (!fs::exists(folder)) {
      std::printf("skipped: there is no %s; name the folder of the data in GEOND_DATA\n", folder.c_str());
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (std::count(kEndings.begin(), kEndings.end(), entry.path().extension().string())) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) PrintRow(file, (file.parent_path().filename() / file.filename()).string());
  return 0;
}

}  // namespace
}  // namespace geond

int main(int argc, char** argv) { return geond::Run(argc, argv); }
