// SPDX-License-Identifier: Apache-2.0
// Any bytes as a mesh or cloud file: read into a sound mesh, or refused by a FileError. The first byte chooses the
// ending.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/base/error.h"
#include "core/geometry/mesh_files.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr const char* kNames[] = {"a.ply", "a.off", "a.obj", "a.stl", "a.pcd", "a.xyz", "a.bin"};
  if (size == 0) return 0;
  try {
    const geond::GeometryFile file =
        geond::ParseGeometry({reinterpret_cast<const char*>(data) + 1, size - 1}, kNames[data[0] % std::size(kNames)]);
    geond::CheckMesh(file.mesh);
    for (const Eigen::Vector3d& p : file.cloud.points) {
      if (!p.allFinite()) std::abort();
    }
    if (file.cloud.empty() || (!file.cloud.normals.empty() && !file.cloud.has_normals())) std::abort();
    geond::Topology(file.mesh);
  } catch (const geond::FileError&) {
  }
  return 0;
}
