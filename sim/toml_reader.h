// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "core/base/error.h"

namespace geond::sim {

// Parses a TOML file. Throws FileError if it cannot be read, ConfigError naming file, line and column if it is no TOML.
toml::table ReadToml(const std::filesystem::path& path);
// The same from text; `name` stands for the file in errors. Throws ConfigError.
toml::table ParseToml(const std::string& text, const std::string& name);

// One table of a TOML file, read key by key. Every error is a ConfigError that names file, line and key. Finish()
// refuses keys that nobody asked for, so that a misspelt key is not silently ignored.
class TomlReader {
 public:
  // `name` is the table's own path in the file ("" for the root, "geon[2]", "noise").
  TomlReader(const toml::table& table, std::filesystem::path file, std::string name);

  bool Has(std::string_view key) const { return table_.contains(key); }
  // A number in [low, high]; `fallback` if the key is absent, an error if there is no fallback either.
  double Number(std::string_view key, std::optional<double> fallback, double low, double high);
  int Integer(std::string_view key, std::optional<int> fallback, int low, int high);
  bool Flag(std::string_view key, bool fallback);
  std::string Text(std::string_view key, std::optional<std::string> fallback);
  // Exactly `count` numbers, each in [low, high].
  std::vector<double> Numbers(std::string_view key, std::size_t count, std::optional<std::vector<double>> fallback,
                              double low = -std::numeric_limits<double>::max(),
                              double high = std::numeric_limits<double>::max());
  // A table below this one; an empty one if the key is absent.
  TomlReader Table(std::string_view key);
  // The tables of [[key]]; none if the key is absent.
  std::vector<TomlReader> Tables(std::string_view key);

  // Throws ConfigError about a key (or, with an empty key, about the table as a whole).
  [[noreturn]] void Fail(std::string_view key, const std::string& cause, const std::string& remedy = {}) const;
  void Finish() const;

 private:
  const toml::node* Find(std::string_view key);
  double Checked(std::string_view key, const toml::node& node, double low, double high) const;

  const toml::table& table_;
  std::filesystem::path file_;
  std::string name_;
  std::set<std::string, std::less<>> known_;
};

}  // namespace geond::sim
