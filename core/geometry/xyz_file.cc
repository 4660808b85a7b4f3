// SPDX-License-Identifier: Apache-2.0
// Plain columns of numbers: x y z, or x y z nx ny nz, parted by blanks, commas or semicolons. Lines from # or // on are
// comments; a first line of names, or with nothing but the number of points, is passed over.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/file_formats.h"
#include "core/geometry/line_reader.h"

namespace geond {
namespace {

constexpr char kSeparators[] = ",;";

// A line of names such as "x,y,z": every word begins with a letter or a quote, and none is a number.
bool IsHeading(std::string_view line, const std::string& name) {
  LineReader words(line, name);
  if (!words.Next()) return false;
  for (std::string_view word = words.Word(kSeparators); !word.empty(); word = words.Word(kSeparators)) {
    const char c = word[0];
    double value = 0.0;
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '"' || c == '_') || ParseNumber(word, value))
      return false;
  }
  return true;
}

// Whether the three columns behind the coordinates are normals: their lengths are 1, or all the same 0.
bool AreUnit(const std::vector<Eigen::Vector3d>& normals) {
  std::size_t n_unit = 0;
  for (const Eigen::Vector3d& n : normals) n_unit += std::abs(n.norm() - 1.0) < 0.05;
  return n_unit * 10 >= normals.size() * 9;
}

}  // namespace

GeometryFile ReadXyz(const FileContent& content) {
  GeometryFile file;
  LineReader lines(content.bytes, content.name);
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> row;
  std::size_t columns = 0;
  std::int64_t announced = -1;
  bool first = true;
  while (lines.Next("#")) {
    std::string_view& rest = lines.rest();
    rest = rest.substr(0, rest.find("//"));
    if (!lines.MoreOnLine()) continue;
    if (rest.find(';') != std::string_view::npos && rest.find(',') != std::string_view::npos) {
      lines.Fail("commas and semicolons on one line", "Write decimals with a point");
    }
    if (first && IsHeading(rest, content.name)) {
      first = false;
      continue;
    }
    row.clear();
    const int number = lines.number();
    while (lines.MoreOnLine() && row.size() < 100) {
      const std::string_view before = rest;
      if (lines.Word(kSeparators).empty()) break;
      rest = before;
      row.push_back(lines.Number("a coordinate", kSeparators));
    }
    if (first && row.size() == 1 && row[0] >= 0 && row[0] == std::floor(row[0]) && row[0] < 1e12) {
      announced = static_cast<std::int64_t>(row[0]);
      first = false;
      continue;
    }
    first = false;
    if (row.size() < 3) {
      lines.Fail(std::to_string(row.size()) + " numbers where x y z are wanted",
                 "A cloud has a line of three numbers or more a point");
    }
    if (columns == 0) columns = row.size();
    if (row.size() != columns) {
      lines.Fail(std::to_string(row.size()) + " numbers where the lines before have " + std::to_string(columns));
    }
    const Eigen::Vector3d p(row[0], row[1], row[2]);
    if (!p.allFinite()) lines.Fail("the point of line " + std::to_string(number) + " is not finite");
    file.cloud.points.push_back(p);
    if (columns >= 6) normals.push_back({row[columns - 3], row[columns - 2], row[columns - 1]});
  }
  if (announced >= 0 && announced != static_cast<std::int64_t>(file.cloud.points.size())) {
    lines.Fail("the first line says " + std::to_string(announced) + " points, but there are " +
                   std::to_string(file.cloud.points.size()),
               "The file may have been cut off");
  }
  if (columns >= 6 && AreUnit(normals)) {
    file.cloud.normals = std::move(normals);
  } else if (columns > 3) {
    file.notes.push_back("columns behind the third were not used: they are no unit normals");
  }
  return Assemble(std::move(file), {}, content.name);
}

std::string XyzText(const PointCloud& cloud) {
  std::string text;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (k > 0) text += ' ';
      AppendNumber(text, cloud.points[i][k]);
    }
    for (int k = 0; k < 3 && cloud.has_normals(); ++k) {
      text += ' ';
      AppendNumber(text, cloud.normals[i][k]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace geond
