// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace geond {

// Goes through a text in memory line by line and word by word, whatever the locale. What is wrong is thrown as
// FileError with the file's name and the line. The text must outlive it.
class LineReader {
 public:
  LineReader(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  // Goes to the next line with a word on it; `comment` (if not empty) and what follows it on a line do not count. Lines
  // end with LF, CR LF or CR. False at the end of the file.
  bool Next(std::string_view comment = {});
  // What is left of the line.
  std::string_view& rest() { return line_; }
  bool MoreOnLine() const;
  // The next word of the line, empty if there is none. Blanks are space, tab and each character of `also`.
  std::string_view Word(std::string_view also = {});
  // The next word of the line as a number or whole number; `what` names it in the error. A number may be nan or
  // infinite.
  double Number(const char* what, std::string_view also = {});
  std::int64_t Integer(const char* what);

  std::size_t position() const { return position_; }  // of the first byte behind the line
  std::size_t remaining() const { return text_.size() - position_; }
  int number() const { return number_; }  // of the line, from 1
  const std::string& file() const { return file_; }

  [[noreturn]] void Fail(const std::string& cause, const std::string& remedy = {}) const;

 private:
  std::string_view text_;
  std::string file_;
  std::string_view line_;
  std::size_t position_ = 0;
  int number_ = 0;
};

// A word in quotes as it may be shown to a person: not long, nothing that upsets a terminal.
std::string Quoted(std::string_view word);

// The whole word as a number ("nan" and "inf" included) or whole number; false if it is none or out of range.
bool ParseNumber(std::string_view word, double& value);
bool ParseInteger(std::string_view word, std::int64_t& value);

}  // namespace geond
