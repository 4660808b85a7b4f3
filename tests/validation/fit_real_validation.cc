// SPDX-License-Identifier: Apache-2.0
// Real data of one part each in the folder GEOND_DATA (or ../shared/data): type found against what the object is, and
// the mean radial residual over the diagonal. mosd_single: single views of boxes and round things. ycb: points of whole
// meshes.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/geometry/cloud_normals.h"
#include "core/geometry/mesh_files.h"
#include "core/geometry/sample_mesh.h"
#include "core/geon/fit.h"
#include "core/geon/objective.h"

namespace geond {
namespace {

namespace fs = std::filesystem;

// Whether the type is what the object's file is named for.
bool IsRight(const std::string& name, GeonType type) {
  const auto holds = [&](const char* word) { return name.find(word) != std::string::npos; };
  if (holds("box")) return type == GeonType::kCuboid;
  if (holds("cylindric") || holds("can")) return type == GeonType::kCylinder;
  if (holds("banana")) return type == GeonType::kCurvedCylinder;
  if (holds("ball")) return type == GeonType::kEllipsoid;
  if (holds("pear")) return type == GeonType::kEllipsoid || type == GeonType::kTaperedCylinder;
  return true;
}

int Run() {
  const char* from = std::getenv("GEOND_DATA");
  const fs::path data = from ? fs::path(from) : fs::path(GEOND_SOURCE_DIR) / "../shared/data";
  for (const char* folder : {"mosd_single", "ycb"}) {
    std::vector<fs::path> files;
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(data / folder, missing)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    int right = 0, count = 0;
    for (const fs::path& file : files) {
      const std::string name = file.stem().string();
      if (name == "hammer" || name == "scissors" || name == "MANIFEST") continue;
      const GeometryFile geometry = ReadGeometry(file);
      const PointCloud part =
          geometry.has_faces() ? SampleMesh(geometry.mesh, 1500) : WithOutwardNormals(geometry.cloud);
      const std::vector<GeonFit> fits = FitGeons(part);
      const GeonFit& best = fits.front();
      double radial = 0.0;
      for (const PointError& error : PointErrors(best.geon, part))
        radial += std::abs(error.e) / static_cast<double>(part.size());
      const double diagonal = BoundingBox(part.points).diagonal().norm();
      right += IsRight(name, best.geon.type);
      ++count;
      std::printf("%-24s %-17s %s confidence %.2f margin %5.2f radial/diagonal %.4f ", name.c_str(),
                  GeonTypeName(best.geon.type).data(), IsRight(name, best.geon.type) ? "ok" : "NO", best.confidence,
                  best.margin, radial / diagonal);
      for (const GeonFit& fit : fits)
        std::printf(" %d:%.5f", static_cast<int>(fit.geon.type), fit.objective / diagonal);
      std::printf("\n");
      std::fflush(stdout);
    }
    std::printf("%s: right %d of %d\n", folder, right, count);
  }
  return 0;
}

}  // namespace
}  // namespace geond

int main() { return geond::Run(); }
