// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "drivers/genicam.h"
#include "drivers/genicam_formula.h"

// The inside of genicam.cc: how one feature is followed down to its registers.
namespace geond::drivers::genicam {

inline constexpr int kMaxDepth = 40;

[[noreturn]] inline void Fail(const std::string& feature, const std::string& cause, const std::string& remedy = {}) {
  throw DeviceError("camera", "feature " + feature, cause, remedy);
}

inline std::int64_t Constant(const std::string& text) {
  return EvaluateInteger(text, [](const std::string& name) -> std::int64_t {
    throw std::domain_error("'" + name + "' is no number");
  });
}

inline double FloatConstant(const std::string& text) {
  return EvaluateFloat(text, [](const std::string& name) -> double {
    throw std::domain_error("'" + name + "' is no number");
  });
}

// One access: follows references, guards against circles.
class Description::Access {
 public:
  Access(const Description& description, std::string feature, const Memory& memory)
      : description_(description), feature_(std::move(feature)), memory_(memory) {}

  template <typename Work>
  auto Run(const Work& work) {
    try {
      return work();
    } catch (const std::domain_error& error) {
      Fail(feature_, error.what());
    }
  }

  const Node& At(const std::string& name) const {
    const auto found = description_.nodes_.find(name);
    if (found == description_.nodes_.end()) {
      Fail(feature_, name == feature_ ? "the camera has none" : "it refers to " + name + ", which the camera has not");
    }
    return found->second;
  }

  std::int64_t Integer(const std::string& name) {
    const Depth depth(*this);
    const Node& node = At(name);
    const std::string& kind = node.kind;
    if (kind == "IntReg" || kind == "MaskedIntReg") return Extract(node, name, ReadPlace(node, name));
    if (kind == "IntSwissKnife") return IntegerFormula(node, Need(node, name, "Formula"), nullptr, 0);
    if (kind == "IntConverter") {
      return IntegerFormula(node, Need(node, name, "FormulaFrom"), "TO", Integer(Need(node, name, "pValue")));
    }
    if (kind == "Integer" || kind == "Enumeration" || kind == "Boolean" || kind == "Command") {
      if (const std::string* target = node.Find("pValue")) return Integer(*target);
      return Constant(Need(node, name, kind == "Command" ? "CommandValue" : "Value"));
    }
    if (kind == "Float" || kind == "FloatReg" || kind == "Converter" || kind == "SwissKnife") {
      const double value = std::round(Float(name));
      if (!(std::abs(value) < 9.2e18)) Fail(feature_, name + " is no whole number");
      return static_cast<std::int64_t>(value);
    }
    Unknown(name, kind);
  }

  double Float(const std::string& name) {
    const Depth depth(*this);
    const Node& node = At(name);
    const std::string& kind = node.kind;
    if (kind == "Float") {
      if (const std::string* target = node.Find("pValue")) return Float(*target);
      return FloatConstant(Need(node, name, "Value"));
    }
    if (kind == "FloatReg") {
      const Place place = Where(node, name);
      const std::uint64_t bits = Raw(place, name);
      if (place.length == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      if (place.length == 8) return std::bit_cast<double>(bits);
      Fail(feature_, name + " is a floating-point register of " + std::to_string(place.length) + " bytes");
    }
    if (kind == "SwissKnife") return FloatFormula(node, Need(node, name, "Formula"), nullptr, 0.0);
    if (kind == "Converter") {
      return FloatFormula(node, Need(node, name, "FormulaFrom"), "TO", Float(Need(node, name, "pValue")));
    }
    return static_cast<double>(Integer(name));
  }

  std::string String(const std::string& name) {
    const Depth depth(*this);
    const Node& node = At(name);
    if (node.kind == "String") {
      if (const std::string* target = node.Find("pValue")) return String(*target);
      return Need(node, name, "Value");
    }
    if (node.kind != "StringReg") Unknown(name, node.kind);
    const Place place = Where(node, name);
    const std::vector<std::uint8_t> bytes = ReadBytes(place, name);
    return std::string(bytes.begin(), std::ranges::find(bytes, 0));
  }

  void SetInteger(const std::string& name, std::int64_t value) {
    const Depth depth(*this);
    const Node& node = At(name);
    CheckWritable(node, name);
    if (node.kind == "IntReg" || node.kind == "MaskedIntReg") return Insert(node, name, value);
    if (node.kind == "IntConverter") {
      return SetInteger(Need(node, name, "pValue"),
                        IntegerFormula(node, Need(node, name, "FormulaTo"), "FROM", value));
    }
    if (node.kind == "Integer" || node.kind == "Enumeration" || node.kind == "Boolean" || node.kind == "Command") {
      if (node.kind == "Integer") CheckRange(node, name, static_cast<double>(value));
      return SetInteger(Need(node, name, "pValue"), value);
    }
    SetFloat(name, static_cast<double>(value));
  }

  void SetFloat(const std::string& name, double value) {
    const Depth depth(*this);
    const Node& node = At(name);
    CheckWritable(node, name);
    if (node.kind == "Float") {
      CheckRange(node, name, value);
      return SetFloat(Need(node, name, "pValue"), value);
    }
    if (node.kind == "FloatReg") {
      const Place place = Where(node, name);
      if (place.length != 4 && place.length != 8) Fail(feature_, name + " has an impossible length");
      return SetRaw(place, place.length == 4 ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                                             : std::bit_cast<std::uint64_t>(value));
    }
    if (node.kind == "Converter") {
      return SetFloat(Need(node, name, "pValue"), FloatFormula(node, Need(node, name, "FormulaTo"), "FROM", value));
    }
    if (node.kind == "Integer" || node.kind == "IntReg" || node.kind == "MaskedIntReg" || node.kind == "IntConverter") {
      if (!(std::abs(value) < 9.2e18)) Fail(feature_, "the value is no number that fits");
      return SetInteger(name, std::llround(value));
    }
    Unknown(name, node.kind);
  }

 private:
  // Counts how deep references go.
  class Depth {
   public:
    explicit Depth(Access& access) : access_(access) {
      if (++access_.depth_ > kMaxDepth) Fail(access_.feature_, "its description goes round in a circle");
    }
    ~Depth() { --access_.depth_; }
    Depth(const Depth&) = delete;
    Depth& operator=(const Depth&) = delete;

   private:
    Access& access_;
  };

  [[noreturn]] void Unknown(const std::string& name, const std::string& kind) const {
    Fail(feature_, name + " is a " + kind + ", which is not understood here");
  }

  const std::string& Need(const Node& node, const std::string& name, const char* tag) const {
    const std::string* text = node.Find(tag);
    if (text == nullptr) Fail(feature_, name + " has no " + tag);
    return *text;
  }

  Place Where(const Node& node, const std::string& name) {
    Place place;
    bool any = false;
    for (const Child& child : node.children) {
      if (child.tag == "Address") {
        place.address += static_cast<std::uint64_t>(Constant(child.text));
      } else if (child.tag == "pAddress") {
        place.address += static_cast<std::uint64_t>(Integer(child.text));
      } else if (child.tag == "pIndex") {
        const bool number = !child.attribute.empty() && child.attribute[0] >= '0' && child.attribute[0] <= '9';
        const std::int64_t step = child.attribute.empty() ? Length(node, name)
                                  : number                ? Constant(child.attribute)
                                                          : Integer(child.attribute);
        place.address += static_cast<std::uint64_t>(Integer(child.text)) * static_cast<std::uint64_t>(step);
      } else if (child.tag == "IntSwissKnife") {
        Fail(feature_, name + " computes its address in place, which is not understood here");
      } else {
        continue;
      }
      any = true;
    }
    if (!any) Fail(feature_, name + " has no address");
    const std::int64_t length = Length(node, name);
    if (length < 1 || length > 0xffff) Fail(feature_, name + " has a length of " + std::to_string(length) + " bytes");
    place.length = static_cast<std::size_t>(length);
    if (const std::string* order = node.Find("Endianess")) place.big_endian = *order == "BigEndian";
    return place;
  }

  std::int64_t Length(const Node& node, const std::string& name) {
    if (const std::string* length = node.Find("Length")) return Constant(*length);
    return Integer(Need(node, name, "pLength"));
  }

  std::vector<std::uint8_t> ReadBytes(const Place& place, const std::string& name) const {
    std::vector<std::uint8_t> bytes = memory_.read(place.address, place.length);
    if (bytes.size() != place.length) Fail(feature_, "the camera gave too few bytes of " + name);
    return bytes;
  }

  std::uint64_t Raw(const Place& place, const std::string& name) const {
    if (place.length > 8) Fail(feature_, name + " is a number of " + std::to_string(place.length) + " bytes");
    std::vector<std::uint8_t> bytes = ReadBytes(place, name);
    if (place.big_endian) std::ranges::reverse(bytes);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) bits |= std::uint64_t{bytes[i]} << (8 * i);
    return bits;
  }

  std::uint64_t ReadPlace(const Node& node, const std::string& name) { return Raw(Where(node, name), name); }

  void SetRaw(const Place& place, std::uint64_t bits) const {
    std::vector<std::uint8_t> bytes(place.length);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
    if (place.big_endian) std::ranges::reverse(bytes);
    memory_.write(place.address, bytes);
  }

  // Lowest bit and number of bits of a masked register. In big-endian registers bit 0 is the highest.
  std::pair<unsigned, unsigned> Field(const Node& node, const std::string& name, const Place& place) const {
    const auto total = static_cast<std::int64_t>(8 * place.length);
    if (node.kind == "IntReg") return {0, static_cast<unsigned>(total)};
    const std::string* bit = node.Find("Bit");
    std::int64_t low = Constant(bit != nullptr ? *bit : Need(node, name, "LSB"));
    std::int64_t high = Constant(bit != nullptr ? *bit : Need(node, name, "MSB"));
    if (place.big_endian) {
      low = total - 1 - low;
      high = total - 1 - high;
    }
    if (low > high) std::swap(low, high);
    if (low < 0 || high >= total) Fail(feature_, name + " has bits outside its register");
    return {static_cast<unsigned>(low), static_cast<unsigned>(high - low + 1)};
  }

  static std::uint64_t Mask(unsigned bits) { return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1; }

  std::int64_t Extract(const Node& node, const std::string& name, std::uint64_t raw) {
    const auto [low, bits] = Field(node, name, Where(node, name));
    std::uint64_t value = (raw >> low) & Mask(bits);
    const std::string* sign = node.Find("Sign");
    const bool negative = sign != nullptr && *sign == "Signed" && ((value >> (bits - 1)) & 1) != 0;
    if (negative) value |= ~Mask(bits);
    return static_cast<std::int64_t>(value);
  }

  void Insert(const Node& node, const std::string& name, std::int64_t value) {
    const Place place = Where(node, name);
    if (place.length > 8) Fail(feature_, name + " is a number of " + std::to_string(place.length) + " bytes");
    const auto [low, bits] = Field(node, name, place);
    const std::string* sign = node.Find("Sign");
    const bool is_signed = sign != nullptr && *sign == "Signed";
    const std::uint64_t limit = Mask(is_signed ? bits - 1 : bits);
    const bool fits = value >= 0 ? static_cast<std::uint64_t>(value) <= limit
                                 : bits == 64 || (is_signed && static_cast<std::uint64_t>(-(value + 1)) <= limit);
    if (!fits) Fail(feature_, std::to_string(value) + " does not fit in " + std::to_string(bits) + " bits");
    std::uint64_t raw = 0;
    if (node.kind == "MaskedIntReg") raw = Raw(place, name) & ~(Mask(bits) << low);
    SetRaw(place, raw | ((static_cast<std::uint64_t>(value) & Mask(bits)) << low));
  }

  void CheckWritable(const Node& node, const std::string& name) {
    for (const char* tag : {"AccessMode", "ImposedAccessMode"}) {
      const std::string* mode = node.Find(tag);
      if (mode != nullptr && *mode == "RO") Fail(feature_, name + " can only be read");
    }
    if (const std::string* lock = node.Find("pIsLocked"); lock != nullptr && Integer(*lock) != 0) {
      Fail(feature_, name + " is locked now", "Stop the acquisition first");
    }
  }

  void CheckRange(const Node& node, const std::string& name, double value) {
    const auto limit = [&](const char* constant, const char* reference, double otherwise) {
      if (const std::string* target = node.Find(reference)) return Float(*target);
      if (const std::string* text = node.Find(constant)) return FloatConstant(*text);
      return otherwise;
    };
    const double lowest = limit("Min", "pMin", -HUGE_VAL), highest = limit("Max", "pMax", HUGE_VAL);
    if (value >= lowest && value <= highest) return;
    Fail(feature_, std::to_string(value) + " is outside the range of " + name + ", " + std::to_string(lowest) + " to " +
                       std::to_string(highest));
  }

  // The value of a formula whose variables are other nodes, but for the one named `own`.
  template <typename T, typename Lookup>
  std::function<T(const std::string&)> Variables(const Node& node, const char* own, T own_value, Lookup lookup) {
    return [this, &node, own, own_value, lookup](const std::string& variable) -> T {
      if (own != nullptr && variable == own) return own_value;
      for (const Child& child : node.children) {
        if (child.attribute != variable) continue;
        if (child.tag == "pVariable") return lookup(child.text);
        if (child.tag == "Constant") return static_cast<T>(FloatConstant(child.text));
      }
      Fail(feature_, "its formula uses '" + variable + "', which nobody defines");
    };
  }
  std::int64_t IntegerFormula(const Node& node, const std::string& formula, const char* own, std::int64_t own_value) {
    return EvaluateInteger(formula, Variables<std::int64_t>(node, own, own_value,
                                                            [this](const std::string& name) { return Integer(name); }));
  }
  double FloatFormula(const Node& node, const std::string& formula, const char* own, double own_value) {
    return EvaluateFloat(formula, Variables<double>(node, own, own_value,
                                                    [this](const std::string& name) { return Float(name); }));
  }

  const Description& description_;
  const std::string feature_;
  const Memory& memory_;
  int depth_ = 0;
};

}  // namespace geond::drivers::genicam
