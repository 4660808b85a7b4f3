// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/mesh_files.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MeshFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("geond_files_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path Put(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  GeometryFile Read(const std::string& name, const std::string& bytes) const { return ReadGeometry(Put(name, bytes)); }
  std::string BytesOf(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    std::stringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
  }

  fs::path folder_;
};

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0.125, 0, 0}, {0, 1.0 / 3.0, 0}, {0, -1e-7, 12345.678901234567}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

PointCloud RandomCloud(bool normals) {
  std::mt19937_64 generator(5);
  const auto uniform = [&] { return static_cast<double>(generator() >> 11) * 0x1p-52 - 1.0; };
  PointCloud cloud;
  for (int i = 0; i < 50; ++i) {
    cloud.points.push_back({uniform(), uniform() * 1e-6, uniform() * 1e6});
    if (normals) cloud.normals.push_back(Eigen::Vector3d(uniform(), uniform(), uniform()).normalized());
  }
  return cloud;
}

TEST_F(MeshFiles, MeshesKeepEveryBit) {
  const TriangleMesh mesh = Tetrahedron();
  for (const char* name : {"a.ply", "a.off", "a.obj", "B.PLY"}) {
    WriteMesh(mesh, folder_ / name);
    const GeometryFile read = ReadGeometry(folder_ / name);
    EXPECT_EQ(read.mesh.vertices, mesh.vertices) << name;
    EXPECT_EQ(read.mesh.triangles, mesh.triangles) << name;
    EXPECT_TRUE(read.notes.empty()) << name;
  }
}

TEST_F(MeshFiles, StlKeepsTrianglesToFloatPrecision) {
  const TriangleMesh mesh = Tetrahedron();
  WriteMesh(mesh, folder_ / "a.stl");
  const TriangleMesh read = ReadGeometry(folder_ / "a.stl").mesh;
  ASSERT_EQ(read.vertices.size(), 4u);
  ASSERT_EQ(read.triangles.size(), 4u);
  for (int t = 0; t < 4; ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = read.vertices[read.triangles[t][k]];
      const Eigen::Vector3d& b = mesh.vertices[mesh.triangles[t][k]];
      EXPECT_LE((a - b).norm(), 1e-7 * b.norm());
    }
  }
  EXPECT_TRUE(Topology(read).closed);
}

TEST_F(MeshFiles, CloudsKeepPointsAndNormals) {
  for (bool normals : {false, true}) {
    const PointCloud cloud = RandomCloud(normals);
    for (const char* name : {"a.ply", "a.xyz", "a.pcd"}) {
      WriteCloud(cloud, folder_ / name);
      const PointCloud read = ReadGeometry(folder_ / name).cloud;
      ASSERT_EQ(read.size(), cloud.size()) << name;
      ASSERT_EQ(read.has_normals(), normals) << name;
      const double tolerance = std::string(name) == "a.pcd" ? 1e-7 : 0.0;
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        EXPECT_LE((read.points[i] - cloud.points[i]).norm(), tolerance * cloud.points[i].norm()) << name;
        if (!normals) continue;
        EXPECT_LE((read.normals[i] - cloud.normals[i]).norm(), std::max(tolerance, 1e-15)) << name;
      }
    }
  }
}

TEST_F(MeshFiles, PlyHoldsWhatIsKnownOfTriangles) {
  TriangleMesh mesh = Tetrahedron();
  mesh.triangle_seen = {1, 0, 1, 1};
  WriteMesh(mesh, folder_ / "a.ply", {{"charge", {1.0, 2.0, 3.0, 4.5}}});
  EXPECT_EQ(ReadGeometry(folder_ / "a.ply").mesh.triangle_seen, mesh.triangle_seen);
  EXPECT_THAT(BytesOf("a.ply"), HasSubstr("property float charge"));
  EXPECT_THROW(WriteMesh(mesh, folder_ / "a.ply", {{"charge", {1.0}}}), std::invalid_argument);
  EXPECT_THROW(WriteMesh(mesh, folder_ / "a.off", {{"charge", {1.0, 2.0, 3.0, 4.5}}}), FileError);
}

TEST_F(MeshFiles, TheSameTriangleInEveryForm) {
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string head = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::pair<const char*, std::string> files[] = {
      {"a.ply", "ply\nformat ascii 1.0\ncomment c\nobj_info o\n" + head + faces + body + "3 0 1 2\n"},
      {"crlf.ply",
       "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n"
       "element face 1\r\nproperty list uchar int vertex_index\r\nend_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 "
       "2\r\n"},
      {"extra.ply",
       "ply\nformat ascii 1.0\nelement camera 1\nproperty list int float focal\nproperty float k\n"
       "element vertex 3\nproperty uchar red\nproperty float x\nproperty float y\nproperty float z\nproperty list "
       "uchar "
       "int tags\nelement face 1\nproperty uchar flags\nproperty list uint8 uint32 vertex_indices\nproperty float q\n"
       "element nothing 0\nproperty int a\nend_header\n2 1 2 3\n9 0 0 0 0\n9 1 0 0 2 7 7\n9 0 1 0 1 4\n1 3 0 1 2 "
       "0.5\n"},
      {"a.off", "OFF\n3 1 0\n" + body + "3 0 1 2\n"},
      {"one_line.off", "OFF 3 1 0\n" + body + "3 0 1 2\n"},
      {"glued.off", "OFF3 1 0\n" + body + "3 0 1 2\n"},
      {"comments.off", "# c\n\nOFF # c\n# c\n3 1 3 # c\n" + body + "\n# c\n3 0 1 2 255 0 0\n"},
      {"colours.off", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 255 0 0 255\n3 0 1 2 0.5 0.5 0.5\n"},
      {"normals.off", "CNOFF\n3 1 0\n0 0 0 0 0 1 1 1 1 1\n1 0 0 0 0 1 1 1 1 1\n0 1 0 0 0 2 1 1 1 1\n3 0 1 2\n"},
      {"mac.off", "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r"},
      {"a.obj", "# c\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nf 1 2 3\n"},
      {"negative.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\ns off\nf -3 -2 -1\n"},
      {"slashes.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1 2/1/1 3//1\n"},
      {"forward.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"},
      {"continued.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n3\n"},
      {"a.stl",
       "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid "
       "s\n"},
      {"upper.stl",
       "SOLID\n FACET NORMAL 0 0 1\n OUTER LOOP\n VERTEX 0 0 0\n VERTEX 1E0 +0 -0.0\n VERTEX 0 1 0\n ENDLOOP\n"
       "ENDFACET\nENDSOLID\n"},
  };
  for (const auto& [name, bytes] : files) {
    SCOPED_TRACE(name);
    const GeometryFile read = Read(name, bytes);
    ASSERT_EQ(read.mesh.vertices.size(), 3u);
    ASSERT_EQ(read.mesh.triangles.size(), 1u);
    EXPECT_EQ(read.mesh.triangles[0], (TriangleMesh::Triangle{0, 1, 2}));
    EXPECT_EQ(read.mesh.vertices[1], Eigen::Vector3d(1, 0, 0));
    EXPECT_EQ(read.mesh.vertices[2], Eigen::Vector3d(0, 1, 0));
    EXPECT_EQ(read.cloud.has_normals(), std::string(name) == "normals.off");
  }
}

TEST_F(MeshFiles, ReadsPlyOfEitherByteOrder) {
  for (bool big : {false, true}) {
    std::string bytes =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\nelement vertex 3\nproperty short x\nproperty float y\nproperty double z\nproperty uchar c\n"
        "element face 1\nproperty list ushort uint vertex_indices\nend_header\n";
    const auto append = [&](auto bits) {
      for (std::size_t k = 0; k < sizeof(bits); ++k) {
        bytes += static_cast<char>(bits >> 8 * (big ? sizeof(bits) - 1 - k : k) & 0xff);
      }
    };
    for (int i = 0; i < 3; ++i) {
      append(static_cast<std::uint16_t>(-i));
      append(std::bit_cast<std::uint32_t>(0.5f * static_cast<float>(i * i)));
      append(std::bit_cast<std::uint64_t>(1e100 * i));
      bytes += '\n';  // a colour that looks like the end of a line
    }
    append(std::uint16_t{3});
    for (int i = 0; i < 3; ++i) append(static_cast<std::uint32_t>(i));
    const GeometryFile read = Read("a.ply", bytes);
    ASSERT_EQ(read.mesh.vertices.size(), 3u);
    EXPECT_EQ(read.mesh.vertices[2], Eigen::Vector3d(-2, 2, 2e100));
    EXPECT_EQ(read.mesh.triangles[0], (TriangleMesh::Triangle{0, 1, 2}));
  }
}

TEST_F(MeshFiles, SplitsPolygonsAlsoConcaveOnes) {
  // An arrow head, a square and a star: the areas say whether the triangles stay within.
  const auto star = [] {
    std::ostringstream text;
    text << "OFF\n10 1 0\n";
    for (int k = 0; k < 10; ++k) {
      const double r = k % 2 ? 0.4 : 1.0, a = 0.628318530717958648 * k;
      text << r * std::cos(a) << " " << r * std::sin(a) << " 2\n";
    }
    text << "10 0 1 2 3 4 5 6 7 8 9\n";
    return text.str();
  };
  const std::tuple<std::string, std::size_t, double> shapes[] = {
      {"OFF\n4 1 0\n0 0 0\n2 1 0\n0 2 0\n1 1 0\n4 0 1 2 3\n", 2, 1.0},
      {"OFF\n4 1 0\n2 1 0\n0 2 0\n1 1 0\n0 0 0\n4 0 1 2 3\n", 2, 1.0},
      {"OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n", 2, 1.0},
      {star(), 8, 10 * 0.5 * 0.4 * std::sin(0.628318530717958648)}};
  for (const auto& [text, n, area] : shapes) {
    const TriangleMesh mesh = Read("a.off", text).mesh;
    ASSERT_EQ(mesh.triangles.size(), n);
    EXPECT_NEAR(Area(mesh), area, 1e-5);
    for (const Eigen::Vector3d& normal : TriangleNormals(mesh)) EXPECT_NEAR(normal.z(), 1.0, 1e-12);
  }
}

TEST_F(MeshFiles, WeldsSeamsOfAMeshThatIsOpenOtherwise) {
  const TriangleMesh mesh = Tetrahedron();
  TriangleMesh loose;
  for (const auto& t : mesh.triangles) {
    const int n = static_cast<int>(loose.vertices.size());
    for (int v : t) loose.vertices.push_back(mesh.vertices[v]);
    loose.triangles.push_back({n, n + 1, n + 2});
  }
  WriteMesh(loose, folder_ / "a.obj");
  const GeometryFile read = ReadGeometry(folder_ / "a.obj");
  EXPECT_TRUE(Topology(read.mesh).closed);
  EXPECT_EQ(read.mesh.vertices.size(), 4u);
  EXPECT_EQ(read.cloud.size(), 12u);
  EXPECT_EQ(read.notes.size(), 1u);
}

TEST_F(MeshFiles, LeavesOutFacesWithACornerTwice) {
  const GeometryFile read = Read("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 0 1\n3 0 1 2\n");
  EXPECT_EQ(read.mesh.triangles.size(), 1u);
  EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("left out")));
}

TEST_F(MeshFiles, ReadsColumnsHoweverParted) {
  const char* texts[] = {"1 2 3\n4 5 6\n",
                         "1,2,3\n4,5,6\n",
                         "1;2;3\r\n4; 5; 6\r\n",
                         "# c\n 1\t2\t3 # c\n\n4 5 6",
                         "x,y,z\n1,2,3\n4,5,6\n",
                         "2\n1 2 3\n4 5 6\n",
                         "// c\n1.0 2e0 +3 9 9 9\n4 5 6 9 9 9\n",
                         "1 2 3 77\n4 5 6 78\n"};
  for (const char* text : texts) {
    const PointCloud cloud = Read("a.xyz", text).cloud;
    ASSERT_EQ(cloud.size(), 2u) << text;
    EXPECT_EQ(cloud.points[0], Eigen::Vector3d(1, 2, 3)) << text;
    EXPECT_EQ(cloud.points[1], Eigen::Vector3d(4, 5, 6)) << text;
    EXPECT_FALSE(cloud.has_normals());
  }
  EXPECT_TRUE(Read("a.csv", "x;y;z;nx;ny;nz\n1;2;3;0;0;1\n4;5;6;1;0;0\n").cloud.has_normals());
}

std::string PcdHeader(const char* data, int points = 3) {
  const std::string n = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb x y z label\nSIZE 4 4 4 4 2\nTYPE U F F "
         "F U\n"
         "COUNT 1 1 1 1 2\nWIDTH " +
         n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA " + data + "\n";
}

TEST_F(MeshFiles, ReadsPcdInAllThreeForms) {
  const std::string text = PcdHeader("ascii") + "1 0 1 2 8 8\n1 nan nan nan 8 8\n1 0.5 1 2 8 8\n";
  std::string points, columns;  // the same, point by point and field by field
  const float x[] = {0.0f, NAN, 0.5f}, y[] = {1.0f, NAN, 1.0f}, z[] = {2.0f, NAN, 2.0f};
  const auto append = [](std::string& to, std::uint32_t bits, int n) {
    for (int k = 0; k < n; ++k) to += static_cast<char>(bits >> 8 * k & 0xff);
  };
  for (int i = 0; i < 3; ++i) {
    append(points, 1, 4);
    for (float c : {x[i], y[i], z[i]}) append(points, std::bit_cast<std::uint32_t>(c), 4);
    append(points, 8, 4);
  }
  for (int i = 0; i < 3; ++i) append(columns, 1, 4);
  for (const float* c : {x, y, z}) {
    for (int i = 0; i < 3; ++i) append(columns, std::bit_cast<std::uint32_t>(c[i]), 4);
  }
  for (int i = 0; i < 3; ++i) append(columns, 8, 4);
  ASSERT_EQ(columns.size(), 60u);
  // LZF: four bytes as they are, then a copy of eight from four back, then 32 + 16 bytes as they are.
  std::string packed = std::string(1, '\3') + columns.substr(0, 4) + std::string("\xc0\x03", 2) +
                       std::string(1, '\x1f') + columns.substr(12, 32) + std::string(1, '\x0f') +
                       columns.substr(44, 16);
  std::string compressed = PcdHeader("binary_compressed");
  append(compressed, static_cast<std::uint32_t>(packed.size()), 4);
  append(compressed, 60, 4);
  compressed += packed;
  for (const std::string& bytes : {text, PcdHeader("binary") + points, compressed}) {
    const GeometryFile read = Read("a.pcd", bytes);
    ASSERT_EQ(read.cloud.size(), 2u);
    EXPECT_EQ(read.cloud.points[1], Eigen::Vector3d(0.5, 1, 2));
    EXPECT_THAT(read.notes, testing::ElementsAre(HasSubstr("nan")));
  }
}

TEST_F(MeshFiles, LeavesOutFewPointsWithoutNormal) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 20\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nend_header\n";
  for (int i = 0; i < 20; ++i) text += std::to_string(i) + (i == 4 ? " 0 0 0 0 0\n" : " 0 0 0 0 2\n");
  const GeometryFile read = Read("a.ply", text);
  EXPECT_EQ(read.cloud.size(), 19u);
  EXPECT_EQ(read.cloud.normals[4], Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(read.notes.size(), 1u);
}

TEST_F(MeshFiles, SaysHowToUnpack) {
  try {
    Read("a.ply.xz", std::string("\xfd"
                                 "7zXZ\0\0\0",
                                 8));
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("xz -dk"));
  }
}

TEST_F(MeshFiles, RefusesToWriteWhatItCannot) {
  EXPECT_THROW(WriteMesh(Tetrahedron(), folder_ / "a.xyz"), FileError);
  EXPECT_THROW(WriteMesh(Tetrahedron(), folder_ / "none" / "a.ply"), FileError);
  EXPECT_THROW(WriteCloud(RandomCloud(false), folder_ / "a.stl"), FileError);
  TriangleMesh broken = Tetrahedron();
  broken.triangles[0][0] = 4;
  EXPECT_THROW(WriteMesh(broken, folder_ / "a.ply"), std::invalid_argument);
}

TEST(Scaled, ScalesEveryLength) {
  GeometryFile file;
  file.mesh = Tetrahedron();
  file.cloud.points = file.mesh.vertices;
  file.cloud.normals.assign(4, Eigen::Vector3d::UnitX());
  const GeometryFile scaled = Scaled(file, 0.001);
  EXPECT_NEAR(Volume(scaled.mesh), 1e-9 * Volume(file.mesh), 1e-20);
  EXPECT_EQ(scaled.cloud.points[1], 0.001 * file.cloud.points[1]);
  EXPECT_EQ(scaled.cloud.normals, file.cloud.normals);
  EXPECT_THROW(Scaled(file, 0.0), std::invalid_argument);
}

TEST(RealFiles, AreReadOrRefusedInOneSentence) {
  const char* variable = std::getenv("GEOND_DATA");
  const fs::path data =
      variable != nullptr ? fs::path(variable) : fs::path(GEOND_SOURCE_DIR) / ".." / "shared" / "data";
  if (!fs::is_directory(data))
    GTEST_SKIP() << "no folder " << data << ": set GEOND_DATA to where the third-party scans are";
  int n_read = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(data)) {
    if (!entry.is_regular_file() || entry.file_size() > 3000000) continue;
    const std::string extension = entry.path().extension().string();
    try {
      const GeometryFile file = ReadGeometry(entry.path());
      CheckMesh(file.mesh);
      ++n_read;
    } catch (const FileError& error) {
      EXPECT_TRUE(extension == ".xz" || extension == ".conf" || extension == ".TXT" || extension == ".md")
          << error.what();
    }
  }
  EXPECT_GE(n_read, 50);
}

}  // namespace
}  // namespace geond
