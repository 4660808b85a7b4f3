// SPDX-License-Identifier: Apache-2.0
#include "daemon/config.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include <toml++/toml.h>

#include "core/base/error.h"
#include "daemon/nearest_name.h"

namespace geond::daemon {
namespace {

[[noreturn]] void Fail(const std::string& file, const toml::node& node, const std::string& key, const std::string& cause,
                       const std::string& remedy) {
  const auto line = node.source().begin.line;
  throw ConfigError(line > 0 ? file + ":" + std::to_string(line) : file, key, cause, remedy);
}

std::string NumberText(double value) {
  std::ostringstream text;
  text.precision(12);
  text << value;
  return text.str();
}

std::string Range(const ConfigKey& key) { return NumberText(key.low) + " to " + NumberText(key.high); }

std::string Choices(const ConfigKey& key) {
  std::string text;
  for (const std::string_view choice : key.choices) text += (text.empty() ? "" : ", ") + std::string(choice);
  return text;
}

void SetNumber(const ConfigKey& key, Config& config, const toml::node& node, const std::string& file) {
  const std::string name(key.name);
  const auto field = key.field(config);
  const bool whole = std::holds_alternative<int*>(field);
  if (whole ? !node.is_integer() : !node.is_number()) {
    Fail(file, node, name, whole ? "it is not a whole number" : "it is not a number", "Allowed: " + Range(key));
  }
  const double value = *node.value<double>();
  if (!(value >= key.low && value <= key.high)) {
    Fail(file, node, name, NumberText(value) + " is out of range", "Allowed: " + Range(key));
  }
  if (whole) {
    *std::get<int*>(field) = static_cast<int>(value);
  } else {
    *std::get<double*>(field) = value;
  }
}

void SetKey(const ConfigKey& key, Config& config, const toml::node& node, const std::string& file) {
  const std::string name(key.name);
  const auto field = key.field(config);
  if (bool* const* flag = std::get_if<bool*>(&field)) {
    if (!node.is_boolean()) Fail(file, node, name, "it is neither true nor false", "Write true or false, without quotes");
    **flag = *node.value<bool>();
  } else if (std::string* const* text = std::get_if<std::string*>(&field)) {
    if (!node.is_string()) Fail(file, node, name, "it is not a text", "Put it in quotes");
    const std::string value = *node.value<std::string>();
    if (!key.choices.empty() && std::find(key.choices.begin(), key.choices.end(), value) == key.choices.end()) {
      const std::string nearest = NearestName(value, key.choices);
      Fail(file, node, name, "'" + value + "' is no choice",
           (nearest.empty() ? "" : "Did you mean '" + nearest + "'? ") + "Allowed: " + Choices(key));
    }
    **text = value;
  } else {
    SetNumber(key, config, node, file);
  }
}

void ReadTable(const toml::table& table, const std::string& prefix, Config& config, const std::string& file) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix.empty() ? std::string(key.str()) : prefix + "." + std::string(key.str());
    if (const toml::table* below = node.as_table(); below && prefix.empty()) {
      ReadTable(*below, name, config, file);
      continue;
    }
    const auto& keys = ConfigKeys();
    const auto known = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& k) { return k.name == name; });
    if (known == keys.end()) {
      std::vector<std::string> names;
      for (const ConfigKey& k : keys) names.emplace_back(k.name);
      const std::string nearest = NearestName(name, names);
      Fail(file, node, name, "there is no such key",
           nearest.empty() ? "config/geond.toml lists them all" : "Did you mean '" + nearest + "'?");
    }
    SetKey(*known, config, node, file);
  }
}

std::string ValueText(const ConfigKey::Field& field) {
  if (bool* const* flag = std::get_if<bool*>(&field)) return **flag ? "true" : "false";
  if (int* const* whole = std::get_if<int*>(&field)) return std::to_string(**whole);
  if (double* const* number = std::get_if<double*>(&field)) {
    const std::string text = NumberText(**number);
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  std::string quoted = "\"";
  for (const char letter : *std::get<std::string*>(field)) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    quoted += letter;
  }
  return quoted + "\"";
}

}  // namespace

Config ParseConfig(std::string_view text, const std::string& name) {
  Config config;
  try {
    ReadTable(toml::parse(text), "", config, name);
  } catch (const toml::parse_error& error) {
    throw ConfigError(name + ":" + std::to_string(error.source().begin.line), "parse", std::string(error.description()),
                      "Mend the line");
  }
  CheckConfig(config, name);
  return config;
}

Config ReadConfig(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw FileError(path.string(), "read", "the configuration cannot be read", "Check path and permissions");
  std::error_code unknown;
  if ((std::filesystem::status(path, unknown).permissions() & std::filesystem::perms::others_write) != std::filesystem::perms::none) {
    throw FileError(path.string(), "check", "others can change it", "Run chmod o-w on it");
  }
  Config config = ParseConfig(text.str(), path.string());
  config.folder = std::filesystem::absolute(path).parent_path();
  return config;
}

void SetConfigKey(Config& config, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::size_t dot = assignment.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot > equals) {
    throw ConfigError("--set", assignment, "it is not table.key=value", "For example: --set scan.views=12");
  }
  const std::string key = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  const auto parse = [&](const std::string& text) {
    ReadTable(toml::parse(key + " = " + text), "", config, "--set " + assignment);
  };
  const auto known = std::find_if(ConfigKeys().begin(), ConfigKeys().end(), [&](const ConfigKey& k) { return k.name == key; });
  const bool bare_text = known != ConfigKeys().end() && std::holds_alternative<std::string*>(known->field(config)) &&
                         (value.empty() || (value.front() != '"' && value.front() != '\''));
  try {
    parse(bare_text ? "'" + value + "'" : value);
  } catch (const toml::parse_error& error) {
    throw ConfigError("--set", assignment, std::string(error.description()), "For example: --set scan.views=12");
  }
}

void CheckConfig(const Config& config, const std::string& name) {
  if (config.store_folder.empty()) {
    throw ConfigError(name, "store.folder", "it is empty", "Name the folder that scans are kept in");
  }
  if (config.http_certificate.empty() != config.http_key.empty()) {
    throw ConfigError(name, config.http_key.empty() ? "http.key" : "http.certificate", "TLS needs both http.certificate and http.key",
                      "Name both files, or neither");
  }
}

std::string ConfigText(Config config) {
  std::string text = "# What geond can be told. Every key stands here with its default.\n";
  std::string table;
  for (const ConfigKey& key : ConfigKeys()) {
    const std::string name(key.name);
    const std::size_t dot = name.find('.');
    if (name.substr(0, dot) != table) {
      table = name.substr(0, dot);
      text += "\n[" + table + "]\n";
    }
    text += "# " + std::string(key.sentence);
    const auto field = key.field(config);
    if (!key.choices.empty()) {
      text += " One of: " + Choices(key) + ".";
    } else if (std::holds_alternative<int*>(field) || std::holds_alternative<double*>(field)) {
      text += " Range: " + Range(key) + ".";
    }
    text += "\n" + name.substr(dot + 1) + " = " + ValueText(field) + "\n";
  }
  return text;
}

std::vector<const ConfigKey*> ChangedKeys(Config before, Config after) {
  std::vector<const ConfigKey*> changed;
  for (const ConfigKey& key : ConfigKeys()) {
    if (ValueText(key.field(before)) != ValueText(key.field(after))) changed.push_back(&key);
  }
  return changed;
}

}  // namespace geond::daemon
