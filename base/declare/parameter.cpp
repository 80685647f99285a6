// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/declare/parameter.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "grtx/base/error.h"

namespace grtx::declare {
namespace {

std::string number_text(double value) {
  if (std::isinf(value)) return "inf";
  return fmt::format("{}", value);
}

/// The type of the key's value, for messages.
std::string type_text(const Parameter& key) {
  if (std::holds_alternative<double*>(key.value)) return "a number";
  if (std::holds_alternative<bool*>(key.value)) return "true or false";
  if (std::holds_alternative<Choice>(key.value)) return "a name";
  return "an integer";
}

std::string wrong_type(const Parameter& key, const std::string& got) {
  return fmt::format("must be {} ({}), not {}", type_text(key), range_text(key), got);
}

template <typename T>
bool parse(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

/// A key that accepts any text also accepts other values, as text. Returns false for all other keys.
bool assign_as_text(const Parameter& key, const std::string& text) {
  const auto* names = std::get_if<Choice>(&key.value);
  if (names == nullptr || !names->names.empty()) return false;
  names->set(text);
  return true;
}

}  // namespace

std::string value_text(const Parameter& key) {
  return std::visit(
      [](const auto& target) -> std::string {
        using T = std::decay_t<decltype(target)>;
        if constexpr (std::is_same_v<T, Choice>) {
          return target.get();
        } else if constexpr (std::is_same_v<T, bool*>) {
          return *target ? "true" : "false";
        } else if constexpr (std::is_same_v<T, double*>) {
          return number_text(*target);
        } else {
          return std::to_string(*target);
        }
      },
      key.value);
}

std::string range_text(const Parameter& key) {
  if (const auto* names = std::get_if<Choice>(&key.value)) {
    return names->names.empty() ? "text" : joined_names(names->names);
  }
  if (std::holds_alternative<bool*>(key.value)) return "true, false";
  if (std::isinf(key.range.max)) return "at least " + number_text(key.range.min);
  return number_text(key.range.min) + " to " + number_text(key.range.max);
}

std::string assign_integer(const Parameter& key, std::int64_t value) {
  if (assign_as_text(key, std::to_string(value))) return {};
  if (std::holds_alternative<double*>(key.value)) return assign_real(key, static_cast<double>(value));
  if (std::holds_alternative<bool*>(key.value) || std::holds_alternative<Choice>(key.value)) {
    return wrong_type(key, fmt::format("the integer {}", value));
  }
  const bool narrow = std::holds_alternative<unsigned*>(key.value);
  const double number = static_cast<double>(value);
  if (value < 0 || number < key.range.min || number > key.range.max ||
      (narrow && value > std::numeric_limits<unsigned>::max())) {
    return fmt::format("must be {}, not {}", range_text(key), value);
  }
  if (narrow) {
    *std::get<unsigned*>(key.value) = static_cast<unsigned>(value);
  } else {
    *std::get<std::uint64_t*>(key.value) = static_cast<std::uint64_t>(value);
  }
  return {};
}

std::string assign_real(const Parameter& key, double value) {
  if (assign_as_text(key, number_text(value))) return {};
  if (!std::holds_alternative<double*>(key.value)) return wrong_type(key, "the number " + number_text(value));
  if (!std::isfinite(value) || value < key.range.min || value > key.range.max) {
    return fmt::format("must be {}, not {}", range_text(key), number_text(value));
  }
  *std::get<double*>(key.value) = value;
  return {};
}

std::string assign_bool(const Parameter& key, bool value) {
  if (assign_as_text(key, value ? "true" : "false")) return {};
  if (!std::holds_alternative<bool*>(key.value)) return wrong_type(key, value ? "true" : "false");
  *std::get<bool*>(key.value) = value;
  return {};
}

std::string assign_string(const Parameter& key, const std::string& value) {
  const auto* names = std::get_if<Choice>(&key.value);
  if (names == nullptr) return wrong_type(key, fmt::format("the text '{}'", value));
  if (!names->names.empty() && std::find(names->names.begin(), names->names.end(), value) == names->names.end()) {
    return unknown_name(value, names->names) + (names->hint.empty() ? "" : "; " + names->hint);
  }
  names->set(value);
  return {};
}

std::string assign_text(const Parameter& key, const std::string& text) {
  if (std::holds_alternative<Choice>(key.value)) return assign_string(key, text);
  if (text == "true" || text == "false") return assign_bool(key, text == "true");
  std::int64_t integer = 0;
  if (parse(text, integer)) return assign_integer(key, integer);
  double real = 0.0;
  if (parse(text, real)) return assign_real(key, real);
  return wrong_type(key, fmt::format("'{}'", text));
}

void require_rules(const ParameterList& list, const std::string& origin) {
  for (const ParameterRule& rule : list.rules()) {
    if (!rule.holds()) throw Error(origin, rule.name, rule.rule);
  }
}

void require_allowed(const ParameterList& list) {
  for (const Parameter& parameter : list.items()) {
    const std::string broken = assign_text(parameter, value_text(parameter));
    if (!broken.empty()) throw Error("configuration", parameter.name, broken);
  }
  require_rules(list, "configuration");
}

}  // namespace grtx::declare
