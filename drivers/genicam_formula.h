// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace geond::drivers::genicam {

// The value of a formula of a camera's description: numbers, names, + - * / % ** & | ^ ~ << >> = <> < > <= >= && || !
// ?: ( ) and the functions ABS NEG SQRT TRUNC FLOOR CEIL ROUND EXP LN. Whole numbers (64 bits) or floating point
// throughout. `variable` gives the value of a name. Throws std::domain_error naming what is not understood or has no
// value.
std::int64_t EvaluateInteger(std::string_view formula, const std::function<std::int64_t(const std::string&)>& variable);
double EvaluateFloat(std::string_view formula, const std::function<double(const std::string&)>& variable);

}  // namespace geond::drivers::genicam
