// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// What a camera can be asked and told, by its own description (GenICam XML): features by name, down to bytes of
// registers.
namespace geond::drivers::genicam {

// The registers of the device. Both throw what the transport throws.
struct Memory {
  std::function<std::vector<std::uint8_t>(std::uint64_t address, std::size_t count)> read;
  std::function<void(std::uint64_t address, std::span<const std::uint8_t> data)> write;
};

// The features of one description. Understood are Integer, Float, Boolean, Enumeration, Command, String, IntReg,
// MaskedIntReg, FloatReg, StringReg, IntConverter, Converter, IntSwissKnife and SwissKnife, through pValue, pAddress
// and pIndex. What is not understood fails when it is used, naming the feature, not when the description is read. All
// accesses throw DeviceError naming the feature and the cause.
class Description {
 public:
  // Throws DeviceError if the text is no GenICam description.
  explicit Description(std::string_view xml);

  std::string model() const { return model_; }
  std::size_t size() const { return nodes_.size(); }
  // It is in the description, and (with memory) the device implements it and has it available now.
  bool Has(const std::string& feature) const { return nodes_.contains(feature); }
  bool Available(const std::string& feature, const Memory& memory) const;

  std::int64_t ReadInteger(const std::string& feature, const Memory& memory) const;
  double ReadFloat(const std::string& feature, const Memory& memory) const;
  std::string ReadEnumeration(const std::string& feature, const Memory& memory) const;  // the entry's name
  std::string ReadString(const std::string& feature, const Memory& memory) const;
  // Within the feature's range, else DeviceError says the range.
  void WriteInteger(const std::string& feature, std::int64_t value, const Memory& memory) const;
  void WriteFloat(const std::string& feature, double value, const Memory& memory) const;
  void WriteEnumeration(const std::string& feature, const std::string& entry, const Memory& memory) const;
  void Execute(const std::string& command, const Memory& memory) const;
  std::vector<std::string> Entries(const std::string& enumeration) const;

 private:
  struct Child {
    std::string tag, text, attribute;  // the attribute: Name of a pVariable, Offset or pOffset of a pIndex
  };
  struct Node {
    std::string kind;
    std::vector<Child> children;
    std::vector<std::pair<std::string, std::int64_t>> entries;  // of an Enumeration
    const std::string* Find(std::string_view tag) const;
  };
  struct Place {
    std::uint64_t address = 0;
    std::size_t length = 0;
    bool big_endian = false;
  };
  class Access;

  std::map<std::string, Node> nodes_;
  std::string model_;
};

}  // namespace geond::drivers::genicam
