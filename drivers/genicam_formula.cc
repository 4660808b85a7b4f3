// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_formula.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

namespace geond::drivers::genicam {
namespace {

constexpr int kMaxDepth = 64;

std::int64_t ToInteger(double value) {
  if (!(std::abs(value) < 9.2e18)) throw std::domain_error("a number too large for whole numbers");
  return static_cast<std::int64_t>(value);
}

// Recursive descent, one level of precedence a step of `Binary`. T is std::int64_t or double.
template <typename T>
class Formula {
 public:
  Formula(std::string_view text, const std::function<T(const std::string&)>& variable)
      : text_(text), variable_(variable) {}

  T Evaluate() {
    const T value = Choice();
    SkipSpace();
    if (position_ != text_.size()) Fail();
    return value;
  }

 private:
  [[noreturn]] void Fail() const {
    throw std::domain_error("formula '" + std::string(text_) + "' is not understood at character " +
                            std::to_string(position_ + 1));
  }

  void SkipSpace() {
    while (position_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[position_])) != 0) ++position_;
  }

  bool Take(std::string_view token) {
    SkipSpace();
    if (!text_.substr(position_).starts_with(token)) return false;
    position_ += token.size();
    return true;
  }

  // Both branches are evaluated: neither may fail.
  T Choice() {
    if (++depth_ > kMaxDepth) throw std::domain_error("formula '" + std::string(text_) + "' is nested too deep");
    const T condition = Binary(0);
    T value = condition;
    if (Take("?")) {
      const T yes = Choice();
      if (!Take(":")) Fail();
      const T no = Choice();
      value = condition != T{0} ? yes : no;
    }
    --depth_;
    return value;
  }

  // The operator at this level of precedence that comes next; empty if none. Longer ones first.
  std::string_view Operator(int level) {
    static constexpr std::string_view kOperators[][5] = {
        {"||"},       {"&&"},     {"|"},          {"^"}, {"&"}, {"<>", "="}, {"<=", ">=", "<", ">"},
        {"<<", ">>"}, {"+", "-"}, {"*", "/", "%"}};
    SkipSpace();
    const std::string_view rest = text_.substr(position_);
    for (std::string_view token : kOperators[level]) {
      if (token.empty() || !rest.starts_with(token)) continue;
      const std::string_view two = rest.substr(0, 2);
      const bool longer = token.size() == 1 && (two == "||" || two == "&&" || two == "<<" || two == ">>" ||
                                                two == "<>" || two == "<=" || two == ">=" || two == "**");
      if (longer) continue;
      position_ += token.size();
      return token;
    }
    return {};
  }

  T Binary(int level) {
    constexpr int kLevels = 10;
    if (level == kLevels) return Unary();
    T left = Binary(level + 1);
    for (std::string_view token = Operator(level); !token.empty(); token = Operator(level)) {
      left = Apply(token, left, Binary(level + 1));
    }
    return left;
  }

  static T Bits(std::uint64_t bits) { return static_cast<T>(static_cast<std::int64_t>(bits)); }
  static std::uint64_t Bits(T value) {
    if constexpr (std::is_same_v<T, double>) return static_cast<std::uint64_t>(ToInteger(value));
    return static_cast<std::uint64_t>(value);
  }

  T Apply(std::string_view token, T a, T b) const {
    const char c = token[0];
    if (token == "||") return a != T{0} || b != T{0};
    if (token == "&&") return a != T{0} && b != T{0};
    if (token == "<>") return a != b;
    if (token == "<=") return a <= b;
    if (token == ">=") return a >= b;
    if (token == "<<" || token == ">>") {
      const std::uint64_t shift = Bits(b);
      if (shift > 63) throw std::domain_error("formula '" + std::string(text_) + "' shifts too far");
      return Bits(token == "<<" ? Bits(a) << shift : Bits(a) >> shift);
    }
    switch (c) {
      case '=': return a == b;
      case '<': return a < b;
      case '>': return a > b;
      case '|': return Bits(Bits(a) | Bits(b));
      case '^': return Bits(Bits(a) ^ Bits(b));
      case '&': return Bits(Bits(a) & Bits(b));
      default: return Arithmetic(c, a, b);
    }
  }

  T Arithmetic(char c, T a, T b) const {
    if ((c == '/' || c == '%') && b == T{0})
      throw std::domain_error("formula '" + std::string(text_) + "' divides by 0");
    if constexpr (std::is_same_v<T, double>) {
      return c == '+' ? a + b : c == '-' ? a - b : c == '*' ? a * b : c == '/' ? a / b : std::fmod(a, b);
    } else {
      // As unsigned numbers, where an overflow is defined.
      if (c == '+') return Bits(Bits(a) + Bits(b));
      if (c == '-') return Bits(Bits(a) - Bits(b));
      if (c == '*') return Bits(Bits(a) * Bits(b));
      if (b == -1) return c == '/' ? Bits(0 - Bits(a)) : 0;
      return c == '/' ? a / b : a % b;
    }
  }

  T Unary() {
    if (++depth_ > kMaxDepth) throw std::domain_error("formula '" + std::string(text_) + "' is nested too deep");
    T value{};
    if (Take("-")) {
      value = Arithmetic('-', T{0}, Unary());
    } else if (Take("+")) {
      value = Unary();
    } else if (Take("~")) {
      value = Bits(~Bits(Unary()));
    } else if (Take("!")) {
      value = Unary() == T{0};
    } else {
      value = Primary();
      if (Take("**")) value = FromDouble(std::pow(static_cast<double>(value), static_cast<double>(Unary())));
    }
    --depth_;
    return value;
  }

  static T FromDouble(double value) {
    if constexpr (std::is_same_v<T, double>) return value;
    return ToInteger(value);
  }

  T Primary() {
    if (Take("(")) {
      const T value = Choice();
      if (!Take(")")) Fail();
      return value;
    }
    if (position_ >= text_.size()) Fail();
    const char c = text_[position_];
    if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') return Number();
    const std::size_t begin = position_;
    while (position_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[position_])) != 0 ||
                                        text_[position_] == '_' || text_[position_] == '.')) {
      ++position_;
    }
    if (begin == position_) Fail();
    const std::string name(text_.substr(begin, position_ - begin));
    return Take("(") ? Function(name) : variable_(name);
  }

  T Number() {
    const std::string_view rest = text_.substr(position_);
    const char* end = rest.data() + rest.size();
    std::from_chars_result result{};
    T value{};
    if (rest.starts_with("0x") || rest.starts_with("0X")) {
      std::uint64_t bits = 0;
      result = std::from_chars(rest.data() + 2, end, bits, 16);
      value = std::is_same_v<T, double> ? static_cast<T>(bits) : Bits(bits);
    } else if constexpr (std::is_same_v<T, double>) {
      result = std::from_chars(rest.data(), end, value);
    } else {
      result = std::from_chars(rest.data(), end, value, 10);
    }
    if (result.ec != std::errc()) Fail();
    position_ += static_cast<std::size_t>(result.ptr - rest.data());
    return value;
  }

  T Function(const std::string& name) {
    const double x = static_cast<double>(Choice());
    if (!Take(")")) Fail();
    if (name == "ABS") return FromDouble(std::abs(x));
    if (name == "NEG") return FromDouble(-x);
    if (name == "SQRT") return FromDouble(std::sqrt(x));
    if (name == "TRUNC") return FromDouble(std::trunc(x));
    if (name == "FLOOR") return FromDouble(std::floor(x));
    if (name == "CEIL") return FromDouble(std::ceil(x));
    if (name == "ROUND") return FromDouble(std::round(x));
    if (name == "EXP") return FromDouble(std::exp(x));
    if (name == "LN") return FromDouble(std::log(x));
    throw std::domain_error("formula '" + std::string(text_) + "' uses the unknown function " + name);
  }

  const std::string_view text_;
  const std::function<T(const std::string&)>& variable_;
  std::size_t position_ = 0;
  int depth_ = 0;
};

}  // namespace

std::int64_t EvaluateInteger(std::string_view formula,
                             const std::function<std::int64_t(const std::string&)>& variable) {
  return Formula<std::int64_t>(formula, variable).Evaluate();
}

double EvaluateFloat(std::string_view formula, const std::function<double(const std::string&)>& variable) {
  return Formula<double>(formula, variable).Evaluate();
}

}  // namespace geond::drivers::genicam
