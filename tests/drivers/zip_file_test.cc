// SPDX-License-Identifier: Apache-2.0
#include "drivers/zip_file.h"

#include <fstream>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

std::string FileText(const std::string& name) {
  std::ifstream file(std::string(GEOND_TEST_DATA) + "/u3v/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(UnzipFirstFile, UnpacksADescription) {
  const std::string packed = FileText("camera.zip");  // made with Python's zipfile
  const std::vector<std::uint8_t> archive(packed.begin(), packed.end());
  EXPECT_EQ(UnzipFirstFile(archive), FileText("camera.xml"));
}

TEST(UnzipFirstFile, RefusesWhatIsBroken) {
  const std::string packed = FileText("camera.zip"), text = FileText("camera.xml");
  const std::vector<std::uint8_t> archive(packed.begin(), packed.end());
  EXPECT_THROW(UnzipFirstFile({}), DeviceError);
  for (std::size_t size = 0; size < archive.size(); ++size) {
    EXPECT_THROW(UnzipFirstFile(std::span(archive).first(size)), DeviceError) << size;
  }
  int refused = 0;
  for (std::size_t at = 0; at < archive.size(); ++at) {
    std::vector<std::uint8_t> damaged = archive;
    damaged[at] ^= 0x55;
    try {
      EXPECT_EQ(UnzipFirstFile(damaged), text) << at;  // a byte that says nothing we need: a name, a date
    } catch (const DeviceError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<int>(archive.size()) / 2);
}

}  // namespace
}  // namespace geond::drivers
