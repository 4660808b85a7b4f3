// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/mesh_files.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"

namespace geond {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;

std::string LowerExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

std::string ReadBytes(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw FileError(path.string(), "open", "there is no such file");
  if (fs::is_directory(status))
    throw FileError(path.string(), "open", "it is a folder, not a file with a mesh or cloud");
  if (!fs::is_regular_file(status)) throw FileError(path.string(), "open", "it is no plain file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw FileError(path.string(), "open", error.message());
  if (size > kMaxFileBytes) throw FileError(path.string(), "open", "it is larger than 1 GiB", "Thin it out first");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError(path.string(), "open", "it cannot be opened", "Check the permissions");
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  if (bytes.size() != size) {
    throw FileError(path.string(), "read byte " + std::to_string(bytes.size()), "the file ended before its size");
  }
  return bytes;
}

void RefusePacked(std::string_view bytes, const std::string& name) {
  struct Packing {
    std::string_view magic;
    const char* command;
  };
  constexpr Packing kPackings[] = {{"\xfd"
                                    "7zXZ",
                                    "xz -dk"},
                                   {"\x1f\x8b", "gunzip -k"},
                                   {"BZh", "bunzip2 -k"},
                                   {"PK\x03\x04", "unzip"},
                                   {"7z\xbc\xaf", "7z x"},
                                   {"\x28\xb5\x2f\xfd", "unzstd"}};
  for (const Packing& packing : kPackings) {
    if (bytes.substr(0, packing.magic.size()) == packing.magic) {
      const bool tar = name.find(".tar.") != std::string::npos;
      throw FileError(name, "read", "the file is packed",
                      "Unpack it first (" + std::string(tar ? "tar -xf" : packing.command) + " " + name + ")");
    }
  }
}

GeometryFile ReadByKind(const FileContent& content, const std::string& extension) {
  if (LooksLikePly(content.bytes)) return ReadPly(content);
  if (LooksLikeOff(content.bytes)) return ReadOff(content);
  if (LooksLikePcd(content.bytes)) return ReadPcd(content);
  if (extension == ".ply") return ReadPly(content);
  if (extension == ".off") return ReadOff(content);
  if (extension == ".pcd") return ReadPcd(content);
  if (extension == ".obj") return ReadObj(content);
  if (extension == ".stl") return ReadStl(content);
  if (extension == ".xyz" || extension == ".txt" || extension == ".asc" || extension == ".csv" || extension == ".pts") {
    return ReadXyz(content);
  }
  if (LooksLikeStl(content.bytes)) return ReadStl(content);
  throw FileError(content.name, "read", "unknown kind of file",
                  "PLY, OFF, OBJ, STL, PCD and XYZ (.xyz .txt .asc .csv .pts) are read");
}

void WriteBytes(const fs::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file)
    throw FileError(path.string(), "write", "the file cannot be written", "Check folder, permissions and free space");
}

}  // namespace

GeometryFile ReadGeometry(const fs::path& path) { return ParseGeometry(ReadBytes(path), path); }

GeometryFile ParseGeometry(std::string_view bytes, const fs::path& path) {
  if (bytes.empty()) throw FileError(path.string(), "read byte 0", "the file is empty");
  RefusePacked(bytes, path.string());
  return ReadByKind({bytes, path.string()}, LowerExtension(path));
}

void WriteMesh(const TriangleMesh& mesh, const fs::path& path,
               const std::map<std::string, std::vector<double>>& triangle_values) {
  CheckMesh(mesh);
  for (const auto& [name, values] : triangle_values) {
    if (values.size() != mesh.triangles.size() || name.empty() || name.find_first_of(" \t\r\n") != std::string::npos) {
      throw std::invalid_argument("WriteMesh: \"" + name + "\" must be one word, and one value a triangle");
    }
  }
  const std::string extension = LowerExtension(path);
  if (!triangle_values.empty() && extension != ".ply") {
    throw FileError(path.string(), "write mesh", "only PLY holds values of triangles",
                    "Give a name that ends with .ply");
  }
  if (extension == ".ply") return WriteBytes(path, PlyText(mesh, triangle_values));
  if (extension == ".off") return WriteBytes(path, OffText(mesh));
  if (extension == ".obj") return WriteBytes(path, ObjText(mesh));
  if (extension == ".stl") return WriteBytes(path, StlText(mesh));
  throw FileError(path.string(), "write mesh", "unknown ending", "Give a name that ends with .ply, .off, .obj or .stl");
}

void WriteCloud(const PointCloud& cloud, const fs::path& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".ply") return WriteBytes(path, PlyText(cloud));
  if (extension == ".pcd") return WriteBytes(path, PcdText(cloud));
  if (extension == ".xyz") return WriteBytes(path, XyzText(cloud));
  throw FileError(path.string(), "write cloud", "unknown ending", "Give a name that ends with .ply, .pcd or .xyz");
}

GeometryFile Scaled(GeometryFile file, double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) throw std::invalid_argument("Scaled: the factor must be positive");
  for (Eigen::Vector3d& p : file.cloud.points) p *= factor;
  for (Eigen::Vector3d& v : file.mesh.vertices) v *= factor;
  for (double& residual : file.cloud.normal_residuals) residual *= factor;
  return file;
}

}  // namespace geond
