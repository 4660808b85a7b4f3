// SPDX-License-Identifier: Apache-2.0
#include "core/geometry/line_reader.h"

#include <charconv>

#include "core/base/error.h"

namespace geond {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

// from_chars knows no plus sign.
std::string_view WithoutPlus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

std::string FailureOf(std::string_view word, const char* what, const char* wanted) {
  if (word.empty()) return std::string("the line ends where ") + what + " is wanted";
  return Quoted(word) + " is no " + wanted + " (" + what + ")";
}

}  // namespace

bool LineReader::Next(std::string_view comment) {
  while (position_ < text_.size()) {
    std::size_t end = position_;
    while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r') ++end;
    line_ = text_.substr(position_, end - position_);
    position_ = end;
    if (end < text_.size()) position_ += text_[end] == '\r' && end + 1 < text_.size() && text_[end + 1] == '\n' ? 2 : 1;
    ++number_;
    if (!comment.empty()) line_ = line_.substr(0, line_.find(comment));
    if (MoreOnLine()) return true;
  }
  line_ = {};
  return false;
}

bool LineReader::MoreOnLine() const {
  for (char c : line_) {
    if (!IsBlank(c)) return true;
  }
  return false;
}

std::string_view LineReader::Word(std::string_view also) {
  const auto blank = [&](char c) { return IsBlank(c) || (!also.empty() && also.find(c) != std::string_view::npos); };
  std::size_t begin = 0;
  while (begin < line_.size() && blank(line_[begin])) ++begin;
  std::size_t end = begin;
  while (end < line_.size() && !blank(line_[end])) ++end;
  const std::string_view word = line_.substr(begin, end - begin);
  line_.remove_prefix(end);
  return word;
}

double LineReader::Number(const char* what, std::string_view also) {
  const std::string_view word = Word(also);
  double value = 0.0;
  if (!ParseNumber(word, value)) Fail(FailureOf(word, what, "number"));
  return value;
}

std::int64_t LineReader::Integer(const char* what) {
  const std::string_view word = Word();
  std::int64_t value = 0;
  if (!ParseInteger(word, value)) Fail(FailureOf(word, what, "whole number"));
  return value;
}

void LineReader::Fail(const std::string& cause, const std::string& remedy) const {
  throw FileError(file_, "read line " + std::to_string(number_), cause, remedy);
}

std::string Quoted(std::string_view word) {
  std::string shown = "\"";
  for (char c : word.substr(0, 30)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (word.size() > 30 ? "...\"" : "\"");
}

bool ParseNumber(std::string_view word, double& value) {
  word = WithoutPlus(word);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (stop != end || word.empty()) return false;
  if (error == std::errc::result_out_of_range) {
    // Too small for a double is zero, too large is nothing anybody meant.
    const std::size_t exponent = word.find_first_of("eE");
    if (exponent == std::string_view::npos || word[exponent + 1] != '-') return false;
    value = 0.0;
    return true;
  }
  return error == std::errc();
}

bool ParseInteger(std::string_view word, std::int64_t& value) {
  word = WithoutPlus(word);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && stop == end && !word.empty();
}

}  // namespace geond
