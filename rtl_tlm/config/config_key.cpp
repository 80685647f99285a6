#include "grtx/rtl_tlm/config/config_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "grtx/base/nearest_name.h"

namespace grtx::sim {
namespace {

std::string number_text(double value) {
  if (std::isinf(value)) return "inf";
  return fmt::format("{}", value);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// What kind of value the key takes, for messages.
std::string type_text(const ConfigKey& key) {
  if (std::holds_alternative<double*>(key.value)) return "a number";
  if (std::holds_alternative<bool*>(key.value)) return "true or false";
  if (std::holds_alternative<Choice>(key.value)) return "a name";
  return "an integer";
}

std::string wrong_type(const ConfigKey& key, const std::string& got) {
  return fmt::format("must be {} ({}), not {}", type_text(key), range_text(key), got);
}

template <typename T>
bool parse(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::string value_text(const ConfigKey& key) {
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

std::string range_text(const ConfigKey& key) {
  if (const auto* names = std::get_if<Choice>(&key.value)) return names->names.empty() ? "text" : joined(names->names);
  if (std::holds_alternative<bool*>(key.value)) return "true, false";
  if (std::isinf(key.max)) return "at least " + number_text(key.min);
  return number_text(key.min) + " to " + number_text(key.max);
}

std::string assign_integer(const ConfigKey& key, std::int64_t value) {
  if (std::holds_alternative<double*>(key.value)) return assign_real(key, static_cast<double>(value));
  if (std::holds_alternative<bool*>(key.value) || std::holds_alternative<Choice>(key.value)) {
    return wrong_type(key, fmt::format("the integer {}", value));
  }
  const bool narrow = std::holds_alternative<unsigned*>(key.value);
  const double number = static_cast<double>(value);
  if (value < 0 || number < key.min || number > key.max || (narrow && value > std::numeric_limits<unsigned>::max())) {
    return fmt::format("must be {}, not {}", range_text(key), value);
  }
  if (narrow) {
    *std::get<unsigned*>(key.value) = static_cast<unsigned>(value);
  } else {
    *std::get<std::uint64_t*>(key.value) = static_cast<std::uint64_t>(value);
  }
  return {};
}

std::string assign_real(const ConfigKey& key, double value) {
  if (!std::holds_alternative<double*>(key.value)) return wrong_type(key, "the number " + number_text(value));
  if (!std::isfinite(value) || value < key.min || value > key.max) {
    return fmt::format("must be {}, not {}", range_text(key), number_text(value));
  }
  *std::get<double*>(key.value) = value;
  return {};
}

std::string assign_bool(const ConfigKey& key, bool value) {
  if (!std::holds_alternative<bool*>(key.value)) return wrong_type(key, value ? "true" : "false");
  *std::get<bool*>(key.value) = value;
  return {};
}

std::string assign_string(const ConfigKey& key, const std::string& value) {
  const auto* names = std::get_if<Choice>(&key.value);
  if (names == nullptr) return wrong_type(key, fmt::format("the text '{}'", value));
  if (!names->names.empty() && std::find(names->names.begin(), names->names.end(), value) == names->names.end()) {
    return fmt::format("must be one of {}, not '{}'; the nearest is '{}'{}", range_text(key), value,
                       nearest_name(value, names->names), names->hint.empty() ? "" : "; " + names->hint);
  }
  names->set(value);
  return {};
}

std::string assign_text(const ConfigKey& key, const std::string& text) {
  if (std::holds_alternative<Choice>(key.value)) return assign_string(key, text);
  if (text == "true" || text == "false") return assign_bool(key, text == "true");
  std::int64_t integer = 0;
  if (parse(text, integer)) return assign_integer(key, integer);
  double real = 0.0;
  if (parse(text, real)) return assign_real(key, real);
  return wrong_type(key, fmt::format("'{}'", text));
}

}  // namespace grtx::sim
