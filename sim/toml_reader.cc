// SPDX-License-Identifier: Apache-2.0
#include "sim/toml_reader.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

namespace geond::sim {
namespace {

std::string Plain(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

toml::table ReadToml(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (!in || std::filesystem::is_directory(path) || !(text << in.rdbuf())) {
    throw FileError(path.string(), "read", "it does not exist or cannot be read", "Check the path and its permissions");
  }
  return ParseToml(text.str(), path.string());
}

toml::table ParseToml(const std::string& text, const std::string& name) {
  try {
    return toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw ConfigError(
        name,
        "line " + std::to_string(error.source().begin.line) + ", column " + std::to_string(error.source().begin.column),
        std::string(error.description()), "Mend the TOML syntax there");
  }
}

TomlReader::TomlReader(const toml::table& table, std::filesystem::path file, std::string name)
    : table_(table), file_(std::move(file)), name_(std::move(name)) {}

void TomlReader::Fail(std::string_view key, const std::string& cause, const std::string& remedy) const {
  const toml::node* node = key.empty() ? &table_ : table_.get(key);
  const auto line = node ? node->source().begin.line : table_.source().begin.line;
  std::string place = line > 0 ? "line " + std::to_string(line) + ", " : "";
  if (key.empty()) {
    place += name_.empty() ? "the file" : "table " + name_;
  } else {
    place += "key " + (name_.empty() ? "" : name_ + ".") + std::string(key);
  }
  throw ConfigError(file_.string(), place, cause, remedy);
}

const toml::node* TomlReader::Find(std::string_view key) {
  known_.emplace(key);
  return table_.get(key);
}

double TomlReader::Checked(std::string_view key, const toml::node& node, double low, double high) const {
  const auto value = node.value<double>();
  if (!value || node.is_boolean() || !std::isfinite(*value)) Fail(key, "is not a number");
  if (*value < low || *value > high) {
    Fail(key, Plain(*value) + " is out of range", "Choose a value from " + Plain(low) + " to " + Plain(high));
  }
  return *value;
}

double TomlReader::Number(std::string_view key, std::optional<double> fallback, double low, double high) {
  const toml::node* node = Find(key);
  if (!node && !fallback) Fail(key, "is missing");
  return node ? Checked(key, *node, low, high) : *fallback;
}

int TomlReader::Integer(std::string_view key, std::optional<int> fallback, int low, int high) {
  const toml::node* node = Find(key);
  if (!node && !fallback) Fail(key, "is missing");
  if (node && !node->is_integer()) Fail(key, "is not a whole number");
  return node ? static_cast<int>(Checked(key, *node, low, high)) : *fallback;
}

bool TomlReader::Flag(std::string_view key, bool fallback) {
  const toml::node* node = Find(key);
  if (node && !node->is_boolean()) Fail(key, "is neither true nor false");
  return node ? *node->value<bool>() : fallback;
}

std::string TomlReader::Text(std::string_view key, std::optional<std::string> fallback) {
  const toml::node* node = Find(key);
  if (!node && !fallback) Fail(key, "is missing");
  if (node && !node->is_string()) Fail(key, "is not a text in quotes");
  return node ? *node->value<std::string>() : *fallback;
}

std::vector<double> TomlReader::Numbers(std::string_view key, std::size_t count,
                                        std::optional<std::vector<double>> fallback, double low, double high) {
  const toml::node* node = Find(key);
  if (!node && !fallback) Fail(key, "is missing");
  if (!node) return *fallback;
  const toml::array* array = node->as_array();
  if (!array || array->size() != count) Fail(key, "is not a list of " + std::to_string(count) + " numbers");
  std::vector<double> values;
  for (const toml::node& element : *array) values.push_back(Checked(key, element, low, high));
  return values;
}

TomlReader TomlReader::Table(std::string_view key) {
  static const toml::table kEmpty;
  const toml::node* node = Find(key);
  if (node && !node->is_table()) Fail(key, "is not a table");
  return {node ? *node->as_table() : kEmpty, file_, name_.empty() ? std::string(key) : name_ + "." + std::string(key)};
}

std::vector<TomlReader> TomlReader::Tables(std::string_view key) {
  const toml::node* node = Find(key);
  std::vector<TomlReader> tables;
  if (!node) return tables;
  const toml::array* array = node->as_array();
  if (!array) Fail(key, "is not a list of tables", "Write [[" + std::string(key) + "]] above each");
  for (const toml::node& element : *array) {
    if (!element.is_table()) Fail(key, "is not a list of tables", "Write [[" + std::string(key) + "]] above each");
    tables.push_back({*element.as_table(), file_, std::string(key) + "[" + std::to_string(tables.size() + 1) + "]"});
  }
  return tables;
}

void TomlReader::Finish() const {
  for (const auto& [key, node] : table_) {
    if (known_.contains(key.str())) continue;
    std::string names;
    for (const std::string& name : known_) names += (names.empty() ? "" : ", ") + name;
    Fail(key.str(), "is not known here", "Known are: " + names);
  }
}

}  // namespace geond::sim
