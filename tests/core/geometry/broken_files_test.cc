// SPDX-License-Identifier: Apache-2.0
// Files that are not what they say: each gets one sentence that names the file and a line or a byte.
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/mesh_files.h"

namespace geond {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using std::string_literals::operator""s;

class BrokenFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              (std::string("geond_broken_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // The error's text; empty if the file was read.
  std::string Failure(const std::string& name, const std::string& bytes) const {
    try {
      ParseGeometry(bytes, name);
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr(name));
      EXPECT_LT(std::string(error.what()).size(), 500u);
      return error.what();
    }
    return {};
  }
  std::string Written(const std::string& name) const {
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    PointCloud cloud;
    cloud.points = mesh.vertices;
    cloud.normals.assign(4, Eigen::Vector3d::UnitZ());
    const std::string extension = fs::path(name).extension();
    if (extension == ".pcd" || extension == ".xyz") WriteCloud(cloud, folder_ / name);
    else WriteMesh(mesh, folder_ / name);
    std::ifstream file(folder_ / name, std::ios::binary);
    std::stringstream bytes;
    bytes << file.rdbuf();
    return bytes.str();
  }

  fs::path folder_;
};

struct Case {
  const char* name;
  std::string bytes;
  const char* says;
};

const std::string kVertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFace = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kAscii = "ply\nformat ascii 1.0\n";
const std::string kPoints = "0 0 0\n1 0 0\n0 1 0\n";
const std::string kPcd = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\n";

TEST_F(BrokenFiles, AreNamedWithLineOrByte) {
  const Case cases[] = {
      {"empty.ply", "", "byte 0"},
      {"not.ply", "hello\n", "line 1"},
      {"no_format.ply", "ply\n" + kVertex + "end_header\n" + kPoints, "no format"},
      {"format.ply", "ply\nformat ebcdic 1.0\n" + kVertex + "end_header\n", "line 2"},
      {"no_end.ply", kAscii + kVertex, "line 6"},
      {"word.ply", kAscii + "elephant vertex 3\n", "line 3"},
      {"negative.ply", kAscii + "element vertex -3\nproperty float x\nend_header\n", "line 3"},
      {"text_count.ply", kAscii + "element vertex many\nend_header\n", "line 3"},
      {"huge.ply", kAscii + "element vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n", "line 7"},
      {"huger.ply", kAscii + "element vertex 99999999999999999999\nproperty float x\nend_header\n", "line 3"},
      {"huge_binary.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 9000000000000000000\nproperty double x\nproperty double "
                          "y\nproperty double z\nend_header\n12345678", "byte"},
      {"no_x.ply", kAscii + "element vertex 1\nproperty float y\nproperty float z\nend_header\n0 0\n", "no x, y and z"},
      {"nothing.ply", kAscii + "element vertex 1000000000000\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n", "no x, y and z"},
      {"type.ply", kAscii + "element vertex 1\nproperty quaternion x\nend_header\n", "line 4"},
      {"orphan.ply", kAscii + "property float x\nend_header\n", "line 3"},
      {"float_list.ply", kAscii + "element face 1\nproperty list float int vertex_indices\nend_header\n", "line 4"},
      {"twice.ply", kAscii + kVertex + kVertex + "end_header\n" + kPoints + kPoints, "twice"},
      {"strips.ply", kAscii + kVertex + "element tristrips 1\nproperty list int int vertex_indices\nend_header\n", "strips"},
      {"short.ply", kAscii + kVertex + "end_header\n0.000 0.000 0.000\n1 0 0\n", "line 9"},
      {"short_line.ply", kAscii + kVertex + "end_header\n0.0 0 0\n1 0\n0 1 0\n", "line 9"},
      {"long_line.ply", kAscii + kVertex + "end_header\n0 0 0 5\n1 0 0\n0 1 0\n", "line 8"},
      {"more.ply", kAscii + kVertex + "end_header\n" + kPoints + "0 0 1\n", "line 11"},
      {"letters.ply", kAscii + kVertex + "end_header\n0 0 0\n1 zero 0\n0 1 0\n", "line 9"},
      {"nan.ply", kAscii + kVertex + "end_header\n0 0 0\n1 nan 0\n0 1 0\n", "line 9"},
      {"inf.ply", kAscii + kVertex + "end_header\n0 0 0\n1 inf 0\n0 1 0\n", "line 9"},
      {"overflow.ply", kAscii + kVertex + "end_header\n0 0 0\n1 1e999 0\n0 1 0\n", "line 9"},
      {"index.ply", kAscii + kVertex + kFace + "end_header\n" + kPoints + "3 0 1 3\n", "line 13"},
      {"negative_index.ply", kAscii + kVertex + kFace + "end_header\n" + kPoints + "3 0 1 -1\n", "line 13"},
      {"half_index.ply", kAscii + kVertex + kFace + "end_header\n" + kPoints + "3 0 1 1.5\n", "line 13"},
      {"two_corners.ply", kAscii + kVertex + kFace + "end_header\n" + kPoints + "2 0 1\n", "line 13"},
      {"long_list.ply", kAscii + kVertex + kFace + "end_header\n" + kPoints + "2000000000 0 1 2\n", "line 13"},
      {"no_list.ply", kAscii + kVertex + "element face 1\nproperty int a\nend_header\n" + kPoints + "3\n", "vertex_indices"},
      {"no_points.ply", kAscii + "element vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n", "no points"},
      {"tail.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\nproperty char z\n"
                   "end_header\nabcdef", "byte"},
      {"empty.off", "OFF\n", "line 1"},
      {"not.off", "FOO\n1 2 3\n", "line 1"},
      {"binary.off", "OFF BINARY\n\1\2\3", "line 1"},
      {"four.off", "4OFF\n1 0 0\n0 0 0 0\n", "line 1"},
      {"huge.off", "OFF\n1000000000 1000000000 0\n0 0 0\n", "line 2"},
      {"overflow.off", "OFF\n9223372036854775807 9223372036854775807 0\n0 0 0\n", "line 2"},
      {"negative.off", "OFF\n-1 0 0\n", "line 2"},
      {"counts.off", "OFF\n3\n" + kPoints, "line 2"},
      {"short.off", "OFF\n3 1 0\n" + kPoints, "than the file can hold"},
      {"fewer.off", "OFF\n4 0 0\n" + kPoints + "         \n\n\n", "line 8"},
      {"index.off", "OFF\n3 1 0\n" + kPoints + "3 0 1 3\n", "line 6"},
      {"negative_index.off", "OFF\n3 1 0\n" + kPoints + "3 0 -1 2\n", "line 6"},
      {"corners.off", "OFF\n3 1 0\n" + kPoints + "999999999999 0 1 2\n", "line 6"},
      {"nan.off", "OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3"},
      {"more.off", "OFF\n3 1 0\n" + kPoints + "3 0 1 2\n3 0 1 2\n", "line 7"},
      {"empty.obj", "\n\n", "no points"},
      {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4"},
      {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4"},
      {"back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 -2 -1\n", "line 4"},
      {"letters.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n", "line 4"},
      {"corners.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "line 4"},
      {"coordinate.obj", "v 0 0\n", "line 1"},
      {"nan.obj", "v 0 0 nan\n", "line 1"},
      {"infinite.obj", "v 0 0 0\nv 0 -inf 0\n", "line 2"},
      {"binary.obj", "\x7f" "ELF\1\2\3\n\0\0"s, "line 1"},
      {"flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\n", "none of its faces"},
      {"empty.stl", "solid\nendsolid\n", "no points"},
      {"short.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "line 4"},
      {"two.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n", "line 7"},
      {"four.stl", "solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 0 0\nvertex 1 0 0\nendfacet\nendsolid\n", "line 6"},
      {"outside.stl", "solid\nvertex 0 0 0\nendsolid\n", "line 2"},
      {"nested.stl", "solid\nfacet\nfacet\n", "line 3"},
      {"word.stl", "solid\nfaucet\n", "line 2"},
      {"nan.stl", "solid\nfacet\nvertex 0 nan 0\n", "line 3"},
      {"tiny.stl", "abc", "byte 3"},
      {"count.stl", std::string(80, 'x') + "\xff\xff\xff\xff" + std::string(50, 'x'), "byte 80"},
      {"longer.stl", std::string(80, 'x') + "\1\0\0\0"s + std::string(51, 'x'), "byte 80"},
      {"nan_binary.stl", std::string(80, 'x') + "\1\0\0\0"s + std::string(50, '\xff'), "byte"},
      {"data.pcd", kPcd, "no line DATA"},
      {"kind.pcd", kPcd + "DATA morse\n0 0 0\n", "line 9"},
      {"fewer.pcd", kPcd + "DATA ascii\n0 0 0\n", "line 10"},
      {"more.pcd", kPcd + "DATA ascii\n0 0 0\n0 0 0\n0 0 0\n", "line 12"},
      {"long.pcd", kPcd + "DATA ascii\n0 0 0 0\n0 0 0\n", "line 10"},
      {"letters.pcd", kPcd + "DATA ascii\n0 0 zero\n0 0 0\n", "line 10"},
      {"binary.pcd", kPcd + "DATA binary\n0123456789", "byte"},
      {"tail.pcd", kPcd + "DATA binary\n" + std::string(24, '\0') + "tail", "byte"},
      {"all_nan.pcd", kPcd + "DATA ascii\nnan nan nan\nnan nan nan\n", "no points"},
      {"no_z.pcd", "VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nPOINTS 1\nDATA ascii\n0 0\n", "no field z"},
      {"size.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 3 4\n", "line 3"},
      {"type.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F Q F\n", "line 4"},
      {"half.pcd", "VERSION 0.7\nFIELDS x y z\nSIZE 4 2 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n0 0 0\n", "type F"},
      {"order.pcd", "VERSION 0.7\nSIZE 4 4 4\nFIELDS x y z\n", "line 2"},
      {"points.pcd", "VERSION 0.7\nFIELDS x y z\nWIDTH 5\nHEIGHT 5\nPOINTS 24\nDATA ascii\n", "line 6"},
      {"huge.pcd", "VERSION 0.7\nFIELDS x y z\nWIDTH 2000000000\nHEIGHT 1\nPOINTS 2000000000\nDATA binary\n0000", "byte"},
      {"huger.pcd", "VERSION 0.7\nFIELDS x y z\nWIDTH 2000000000\nHEIGHT 2000000000\nDATA ascii\n0 0 0\n", "line 6"},
      {"packed.pcd", kPcd + "DATA binary_compressed\n\x05\0\0\0\x18\0\0\0"s, "byte"},
      {"bomb.pcd", "VERSION 0.7\nFIELDS x y z\nWIDTH 100000000\nHEIGHT 1\nDATA binary_compressed\n\x04\0\0\0\0\x8c\x86\x47"s + "abcd", "byte"},
      {"lzf.pcd", kPcd + "DATA binary_compressed\n\x04\0\0\0\x18\0\0\0\xff\xff\xff\xff"s, "damaged"},
      {"empty.xyz", "# nothing\n", "no points"},
      {"two.xyz", "1 2\n3 4\n", "line 1"},
      {"ragged.xyz", "1 2 3\n1 2 3 4\n", "line 2"},
      {"letters.xyz", "1 2 3\n1 two 3\n", "line 2"},
      {"nan.xyz", "1 2 3\n1 nan 3\n", "line 2"},
      {"decimals.xyz", "1,5;2,5;3,5\n", "line 1"},
      {"count.xyz", "5\n1 2 3\n", "says 5 points"},
      {"rubbish.xyz", "\1\2\3\4\5", "line 1"},
      {"unknown.foo", "what is this\n", "unknown kind"},
  };
  for (const Case& c : cases) {
    const std::string failure = Failure(c.name, c.bytes);
    EXPECT_THAT(failure, HasSubstr(c.says)) << c.name;
  }
}

TEST_F(BrokenFiles, FoldersAndAbsentFilesAreNamed) {
  EXPECT_THROW(ReadGeometry(folder_ / "absent.ply"), FileError);
  EXPECT_THROW(ReadGeometry(folder_), FileError);
  EXPECT_THROW(ReadGeometry("/dev/null"), FileError);
}

TEST_F(BrokenFiles, NoTruncationIsReadAsTheWhole) {
  for (const char* name : {"a.ply", "a.off", "a.obj", "a.stl", "a.pcd", "a.xyz"}) {
    const std::string whole = Written(name);
    const std::size_t n_points = ReadGeometry(folder_ / name).cloud.size();
    ASSERT_EQ(n_points, 4u) << name;
    int refused = 0;
    for (std::size_t n = 0; n < whole.size(); ++n) {
      const std::string failure = Failure(std::string("cut_") + name, whole.substr(0, n));
      refused += !failure.empty();
      const std::string extension = fs::path(name).extension();
      // Text formats without counts can end after any line; OFF may lose the digits or the end of its last line only.
      if (extension == ".ply" || extension == ".stl" || extension == ".pcd" || (extension == ".off" && n + 3 < whole.size())) {
        EXPECT_FALSE(failure.empty()) << name << " cut to " << n << " of " << whole.size();
      }
    }
    EXPECT_GT(refused, 0) << name;
  }
}

TEST_F(BrokenFiles, NoByteChangedCrashes) {
  std::mt19937_64 generator(3);
  for (const char* name : {"a.ply", "a.off", "a.obj", "a.stl", "a.pcd", "a.xyz"}) {
    const std::string whole = Written(name);
    for (int round = 0; round < 300; ++round) {
      std::string bytes = whole;
      for (int k = 0; k <= round % 3; ++k) bytes[generator() % bytes.size()] = static_cast<char>(generator());
      try {
        const GeometryFile file = ParseGeometry(bytes, name);
        CheckMesh(file.mesh);
      } catch (const FileError&) {
      }
    }
  }
}

TEST_F(BrokenFiles, RubbishIsRefusedWhateverItsName) {
  std::mt19937_64 generator(4);
  for (const char* name : {"a.ply", "a.off", "a.obj", "a.stl", "a.pcd", "a.xyz", "a.foo"}) {
    for (int round = 0; round < 20; ++round) {
      std::string bytes;
      for (int i = 0; i < 400; ++i) bytes += static_cast<char>(generator());
      EXPECT_FALSE(Failure(name, bytes).empty());
    }
  }
}

}  // namespace
}  // namespace geond
