// SPDX-License-Identifier: Apache-2.0
// Parses texts as option values and checks their rules, with the same error messages as the command line.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/experiment/option_rules.h"

namespace grtx::experiment {

/// Parses the whole text as a number; integers may be hexadecimal (0x1F). Returns false if it is none or out of range.
template <typename Number>
bool number_from(const std::string& text, Number& number) {
  char* end = nullptr;
  if constexpr (std::is_floating_point_v<Number>) {
    number = static_cast<Number>(std::strtold(text.c_str(), &end));
    return !text.empty() && end == text.c_str() + text.size();
  } else {
    const std::uint64_t wide = std::strtoull(text.c_str(), &end, 0);
    number = static_cast<Number>(wide);
    return !text.empty() && end == text.c_str() + text.size() && static_cast<std::uint64_t>(number) == wide;
  }
}

/// Error message for a text that is no number from low to high.
std::string out_of_range(double low, double high, const std::string& text);
/// Error message for a text that cannot be converted to the option's type.
std::string not_converted(const std::string& flag, const std::string& text);

/// Error message if the text breaks the rule, else "".
template <typename Number>
std::string breach(const InRange<Number>& rule, const std::string& text) {
  Number number{};
  if (number_from(text, number) && !(number < rule.low || number > rule.high)) return {};
  return out_of_range(static_cast<double>(rule.low), static_cast<double>(rule.high), text);
}
std::string breach(const OneOf& rule, const std::string& text);
std::string breach(const AnyOf& rule, const std::string& text);

/// Splits a text at commas.
std::vector<std::string> pieces_of(const std::string& text);

template <typename Value>
bool convert(const std::string& text, Value& value) {
  if constexpr (NamedEnum<Value>) {
    const std::optional<Value> named = from_name<Value>(text);
    if (named) value = *named;
    return named.has_value();
  } else if constexpr (std::is_same_v<Value, std::string>) {
    value = text;
    return true;
  } else if constexpr (std::is_same_v<Value, std::optional<unsigned>>) {
    return number_from(text, value.emplace());
  } else {
    return number_from(text, value);
  }
}

/// Parses a text into `value`, the value of the option `flag`. Returns "" on success, else an error message; then
/// `value` is unchanged.
template <typename Value, typename... Rule>
std::string take(const std::string& flag, const std::string& text, Value& value, const Rule&... rule) {
  std::string why;
  if constexpr (NamedEnum<Value>) {
    why = breach(OneOf{names_of<Value>()}, text);
  } else {
    ((why = why.empty() ? breach(rule, text) : why), ...);
  }
  if (!why.empty()) return flag + ": " + why;
  Value taken = value;
  if (!convert(text, taken)) return not_converted(flag, text);
  value = std::move(taken);
  return {};
}

/// The same for a list of numbers.
std::string take(const std::string& flag, const std::string& text, std::vector<double>& value, const ListOf& rule);

}  // namespace grtx::experiment
