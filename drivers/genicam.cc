// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam.h"

#include <algorithm>
#include <stdexcept>

#include <pugixml.hpp>

#include "core/base/error.h"
#include "drivers/genicam_access.h"

namespace geond::drivers::genicam {
namespace {

std::string Trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kSpace) - begin + 1));
}

}  // namespace

const std::string* Description::Node::Find(std::string_view tag) const {
  const auto found = std::ranges::find(children, tag, &Child::tag);
  return found == children.end() ? nullptr : &found->text;
}

Description::Description(std::string_view xml) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result) {
    throw DeviceError("camera", "read description",
                      std::string(result.description()) + " at byte " + std::to_string(result.offset));
  }
  const pugi::xml_node root = document.child("RegisterDescription");
  if (!root) throw DeviceError("camera", "read description", "it is no GenICam register description");
  model_ = root.attribute("ModelName").value();
  const std::function<void(const pugi::xml_node&)> add = [&](const pugi::xml_node& parent) {
    for (const pugi::xml_node& element : parent.children()) {
      if (std::string_view(element.name()) == "Group") {
        add(element);
        continue;
      }
      const std::string name = element.attribute("Name").value();
      if (name.empty()) continue;
      Node node{element.name(), {}, {}};
      for (const pugi::xml_node& child : element.children()) {
        const std::string_view tag = child.name();
        if (tag == "EnumEntry") {
          try {
            node.entries.emplace_back(child.attribute("Name").value(), Constant(child.child_value("Value")));
          } catch (const std::domain_error& error) {
            throw DeviceError("camera", "read description", "entry of " + name + ": " + error.what());
          }
          continue;
        }
        const char* attribute = tag == "pIndex" ? (child.attribute("Offset") ? "Offset" : "pOffset") : "Name";
        node.children.push_back({std::string(tag), Trimmed(child.child_value()), child.attribute(attribute).value()});
      }
      nodes_.emplace(name, std::move(node));
    }
  };
  add(root);
}

bool Description::Available(const std::string& feature, const Memory& memory) const {
  if (!Has(feature)) return false;
  Access access(*this, feature, memory);
  return access.Run([&] {
    for (const char* tag : {"pIsImplemented", "pIsAvailable"}) {
      const std::string* condition = access.At(feature).Find(tag);
      if (condition != nullptr && access.Integer(*condition) == 0) return false;
    }
    return true;
  });
}

std::int64_t Description::ReadInteger(const std::string& feature, const Memory& memory) const {
  Access access(*this, feature, memory);
  return access.Run([&] { return access.Integer(feature); });
}

double Description::ReadFloat(const std::string& feature, const Memory& memory) const {
  Access access(*this, feature, memory);
  return access.Run([&] { return access.Float(feature); });
}

std::string Description::ReadEnumeration(const std::string& feature, const Memory& memory) const {
  const std::int64_t value = ReadInteger(feature, memory);
  for (const auto& [name, number] : nodes_.at(feature).entries) {
    if (number == value) return name;
  }
  Fail(feature, "its value " + std::to_string(value) + " has no name");
}

std::string Description::ReadString(const std::string& feature, const Memory& memory) const {
  Access access(*this, feature, memory);
  return access.Run([&] { return access.String(feature); });
}

void Description::WriteInteger(const std::string& feature, std::int64_t value, const Memory& memory) const {
  Access access(*this, feature, memory);
  access.Run([&] { access.SetInteger(feature, value); });
}

void Description::WriteFloat(const std::string& feature, double value, const Memory& memory) const {
  Access access(*this, feature, memory);
  access.Run([&] { access.SetFloat(feature, value); });
}

std::vector<std::string> Description::Entries(const std::string& enumeration) const {
  std::vector<std::string> names;
  if (const auto found = nodes_.find(enumeration); found != nodes_.end()) {
    for (const auto& [name, value] : found->second.entries) names.push_back(name);
  }
  return names;
}

void Description::WriteEnumeration(const std::string& feature, const std::string& entry, const Memory& memory) const {
  Access access(*this, feature, memory);
  std::string known;
  for (const auto& [name, value] : access.At(feature).entries) {
    if (name == entry) return access.Run([&, number = value] { access.SetInteger(feature, number); });
    known += (known.empty() ? "" : ", ") + name;
  }
  Fail(feature, "'" + entry + "' is none of its values: " + known);
}

void Description::Execute(const std::string& command, const Memory& memory) const {
  Access access(*this, command, memory);
  access.Run([&] {
    const Node& node = access.At(command);
    if (node.kind != "Command") Fail(command, "it is no command");
    std::int64_t value = 1;
    if (const std::string* text = node.Find("CommandValue")) value = Constant(*text);
    if (const std::string* target = node.Find("pCommandValue")) value = access.Integer(*target);
    access.SetInteger(command, value);
  });
}

}  // namespace geond::drivers::genicam
