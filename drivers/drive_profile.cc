// SPDX-License-Identifier: Apache-2.0
#include "drivers/drive_profile.h"

#include <charconv>
#include <set>

#include <toml++/toml.h>

#include "core/base/error.h"

namespace geond::drivers {
namespace {

// Reads keys of one file, so that every complaint names file and line.
class ProfileReader {
 public:
  explicit ProfileReader(const std::filesystem::path& path) : file_(path.string()) {
    try {
      root_ = toml::parse_file(file_);
    } catch (const toml::parse_error& error) {
      throw ConfigError(file_ + ":" + std::to_string(error.source().begin.line), "read a drive profile",
                        std::string(error.description()), "See config/drives for profiles that work");
    }
  }
  const toml::table& root() const { return root_; }

  [[noreturn]] void Refuse(const toml::node* node, const std::string& what) const {
    const std::string line = node ? ":" + std::to_string(node->source().begin.line) : "";
    throw ConfigError(file_ + line, "read a drive profile", what, "See config/drives for profiles that work");
  }
  const toml::node& Need(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (!node) Refuse(&table, "the key '" + std::string(key) + "' is missing");
    return *node;
  }
  double Number(const toml::node& node, std::string_view key, double low, double high) const {
    const std::optional<double> value = node.value<double>();
    if (!value || !(*value >= low && *value <= high)) {
      Refuse(&node, "'" + std::string(key) + "' must be a number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return *value;
  }
  double Number(const toml::table& table, std::string_view key, double low, double high) const {
    return Number(Need(table, key), key, low, high);
  }
  std::string Word(const toml::table& table, std::string_view key, const std::vector<std::string>& allowed) const {
    const toml::node& node = Need(table, key);
    const std::string word = node.value_or<std::string>("");
    std::string list;
    for (const std::string& one : allowed) {
      if (one == word) return word;
      list += (list.empty() ? "" : ", ") + one;
    }
    Refuse(&node, "'" + std::string(key) + "' must be one of " + list);
  }
  const toml::table& Table(const toml::table& table, std::string_view key) const {
    const toml::node& node = Need(table, key);
    if (!node.is_table()) Refuse(&node, "'" + std::string(key) + "' must be a table");
    return *node.as_table();
  }
  void OnlyKeys(const toml::table& table, const std::set<std::string_view>& known) const {
    for (const auto& [key, node] : table) {
      if (!known.contains(key.str())) Refuse(&node, "there is no key '" + std::string(key.str()) + "' here");
    }
  }

 private:
  std::string file_;
  toml::table root_;
};

DriveRegister::Type ReadType(const ProfileReader& reader, const toml::node& node) {
  const std::string word = node.value_or<std::string>("");
  if (word == "u16") return DriveRegister::Type::kU16;
  if (word == "i16") return DriveRegister::Type::kI16;
  if (word == "u32") return DriveRegister::Type::kU32;
  if (word == "i32") return DriveRegister::Type::kI32;
  reader.Refuse(&node, "a type must be u16, i16, u32 or i32");
}

DriveRegister ReadRegister(const ProfileReader& reader, const toml::table& table, std::string_view key) {
  const toml::table& entry = reader.Table(table, key);
  reader.OnlyKeys(entry, {"address", "type", "mask"});
  return {static_cast<std::uint16_t>(reader.Number(entry, "address", 0, 0xffff)), ReadType(reader, reader.Need(entry, "type"))};
}

std::uint32_t BitMask(const ProfileReader& reader, const toml::table& bits, std::string_view key) {
  return bits.contains(key) ? std::uint32_t{1} << static_cast<int>(reader.Number(bits, key, 0, 31)) : 0;
}

DriveStep ReadWrite(const ProfileReader& reader, const toml::table& entry) {
  reader.OnlyKeys(entry, {"write", "values"});
  DriveStep step;
  step.address = static_cast<std::uint16_t>(reader.Number(entry, "write", 0, 0xffff));
  const toml::node& values = reader.Need(entry, "values");
  if (!values.is_array() || values.as_array()->empty()) reader.Refuse(&values, "'values' must be a list of [type, value]");
  for (const toml::node& pair : *values.as_array()) {
    const toml::array* two = pair.as_array();
    if (!two || two->size() != 2) reader.Refuse(&pair, "each of 'values' must be [type, value]");
    const DriveRegister::Type type = ReadType(reader, *two->get(0));
    static const std::set<std::string> known{"target", "speed", "accel", "decel", "lifetime_ms"};
    if (const auto number = two->get(1)->value_exact<std::int64_t>()) {
      step.values.emplace_back(type, *number);
    } else if (const auto name = two->get(1)->value_exact<std::string>(); name && known.contains(*name)) {
      step.values.emplace_back(type, *name);
    } else {
      reader.Refuse(two->get(1), "a value must be a whole number or one of target, speed, accel, decel, lifetime_ms");
    }
  }
  return step;
}

DriveStep ReadWait(const ProfileReader& reader, const toml::table& entry, const std::map<std::string, std::uint32_t>& bits) {
  reader.OnlyKeys(entry, {"wait", "timeout_ms"});
  DriveStep step;
  step.kind = DriveStep::Kind::kWait;
  const toml::node& wait = reader.Need(entry, "wait");
  if (!wait.is_array()) reader.Refuse(&wait, "'wait' must be a list of names of status bits");
  for (const toml::node& node : *wait.as_array()) {
    std::string name = node.value_or<std::string>("");
    step.name += (step.name.empty() ? "" : ", ") + name;
    const bool set = name.empty() || name[0] != '!';
    if (!set) name.erase(0, 1);
    const auto bit = bits.find(name);
    if (bit == bits.end() || bit->second == 0) reader.Refuse(&node, "no status bit is called '" + name + "'");
    step.mask |= bit->second;
    if (set) step.equals |= bit->second;
  }
  step.timeout = std::chrono::milliseconds(static_cast<int>(reader.Number(entry, "timeout_ms", 1, 600'000)));
  return step;
}

}  // namespace

DriveProfile ReadDriveProfile(const std::filesystem::path& path) {
  const ProfileReader reader(path);
  const toml::table& root = reader.root();
  reader.OnlyKeys(root, {"name", "word_order", "steps_per_turn", "speed_factor", "accel", "accel_factor", "lifetime_ms",
                         "serial", "registers", "status_bits", "communication_timeout", "alarms", "enable", "home", "move",
                         "stop", "quick_stop", "disable", "reset"});
  DriveProfile profile;
  profile.name = reader.Need(root, "name").value_or<std::string>("");
  profile.high_word_first = reader.Word(root, "word_order", {"high_first", "low_first"}) == "high_first";
  profile.steps_per_turn = reader.Number(root, "steps_per_turn", 1, 1e9);
  profile.speed_factor = reader.Number(root, "speed_factor", 1e-9, 1e9);
  const std::string accel = reader.Word(root, "accel", {"time", "rate", "time_per_1000_rpm"});
  profile.accel = accel == "rate"   ? DriveProfile::Accel::kRate
                  : accel == "time" ? DriveProfile::Accel::kTime
                                    : DriveProfile::Accel::kTimePerThousandRpm;
  profile.accel_factor = reader.Number(root, "accel_factor", 1e-9, 1e9);
  profile.lifetime = std::chrono::milliseconds(static_cast<int>(reader.Number(root, "lifetime_ms", 0, 32767)));

  const toml::table& serial = reader.Table(root, "serial");
  reader.OnlyKeys(serial, {"baud", "parity", "stop_bits"});
  profile.baud = static_cast<int>(reader.Number(serial, "baud", 1200, 4'000'000));
  const std::string parity = reader.Word(serial, "parity", {"none", "even", "odd"});
  profile.parity = parity == "none" ? 'N' : parity == "even" ? 'E' : 'O';
  profile.stop_bits = static_cast<int>(reader.Number(serial, "stop_bits", 1, 2));

  const toml::table& registers = reader.Table(root, "registers");
  reader.OnlyKeys(registers, {"status", "position", "alarm"});
  profile.status = ReadRegister(reader, registers, "status");
  profile.position = ReadRegister(reader, registers, "position");
  profile.alarm = ReadRegister(reader, registers, "alarm");
  profile.alarm_mask = static_cast<std::uint32_t>(reader.Number(*registers["alarm"].as_table(), "mask", 1, 4294967295.0));

  const toml::table& bits = reader.Table(root, "status_bits");
  reader.OnlyKeys(bits, {"moving", "in_position", "alarmed", "homed", "enabled"});
  profile.moving = BitMask(reader, bits, "moving");
  profile.in_position = BitMask(reader, bits, "in_position");
  profile.alarmed = BitMask(reader, bits, "alarmed");
  profile.homed = BitMask(reader, bits, "homed");
  profile.enabled = BitMask(reader, bits, "enabled");
  if (!profile.moving || !profile.alarmed) reader.Refuse(&bits, "'moving' and 'alarmed' must be given");

  if (root.contains("communication_timeout")) {
    const toml::table& timeout = reader.Table(root, "communication_timeout");
    profile.communication_timeout = ReadRegister(reader, timeout, "register");
    profile.communication_timeout_value = std::chrono::milliseconds(static_cast<int>(reader.Number(timeout, "value_ms", 1, 60'000)));
  }
  const std::map<std::string, std::uint32_t> names{{"moving", profile.moving}, {"in_position", profile.in_position},
                                                   {"alarmed", profile.alarmed}, {"homed", profile.homed},
                                                   {"enabled", profile.enabled}};
  for (const char* name : {"enable", "home", "move", "stop", "quick_stop", "disable", "reset"}) {
    const toml::node& steps = reader.Need(root, name);
    if (!steps.is_array_of_tables()) reader.Refuse(&steps, std::string("'") + name + "' must be a list of steps");
    for (const toml::node& step : *steps.as_array()) {
      const toml::table& entry = *step.as_table();
      profile.sequences[name].push_back(entry.contains("wait") ? ReadWait(reader, entry, names) : ReadWrite(reader, entry));
    }
  }
  if (const toml::table* alarms = root["alarms"].as_table()) {
    for (const auto& [key, words] : *alarms) {
      std::uint32_t code = 0;
      const std::string_view digits = key.str();
      const bool hex = digits.starts_with("0x");
      const auto [end, error] = std::from_chars(digits.data() + (hex ? 2 : 0), digits.data() + digits.size(), code, hex ? 16 : 10);
      if (error != std::errc() || end != digits.data() + digits.size()) reader.Refuse(&words, "an alarm's key must be its number");
      profile.alarm_words[code] = words.value_or<std::string>("");
    }
  }
  return profile;
}

}  // namespace geond::drivers
