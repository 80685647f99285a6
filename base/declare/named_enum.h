// Enumerations with names: one table an enumeration, beside it, for configuration, command line, files and messages.
//
//   enum class Order : std::uint8_t { fifo, lifo };
//   constexpr auto enum_names(Order) {
//     using enum Order;
//     return std::to_array<EnumName<Order>>({{fifo, "fifo"}, {lifo, "lifo"}});
//   }
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx {

template <typename Enum>
struct EnumName {
  Enum value;
  std::string_view name;
};

/// An enumeration with a table, which enum_names(Enum) in its own namespace returns.
template <typename Enum>
concept NamedEnum = std::is_enum_v<Enum> && requires(Enum value) {
  enum_names(value);
};

/// The value's name; "?" for what is no value of the enumeration.
template <NamedEnum Enum>
constexpr std::string_view name_of(Enum value) {
  for (const EnumName<Enum>& entry : enum_names(Enum{})) {
    if (entry.value == value) return entry.name;
  }
  return "?";
}

template <NamedEnum Enum>
constexpr std::optional<Enum> from_name(std::string_view name) {
  for (const EnumName<Enum>& entry : enum_names(Enum{})) {
    if (entry.name == name) return entry.value;
  }
  return std::nullopt;
}

/// All names, in the order of the table.
template <NamedEnum Enum>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const EnumName<Enum>& entry : enum_names(Enum{})) names.emplace_back(entry.name);
  return names;
}

/// "a, b, c".
std::string joined_names(const std::vector<std::string>& names);

/// The rule that `name` breaks when it is none of `known`: lists them and the nearest.
std::string unknown_name(std::string_view name, const std::vector<std::string>& known);

/// from_name(), or Error{file, place, unknown_name()}.
template <NamedEnum Enum>
Enum value_of(std::string_view name, const std::string& file, const std::string& place) {
  const std::optional<Enum> value = from_name<Enum>(name);
  if (!value) throw Error(file, place, unknown_name(name, names_of<Enum>()));
  return *value;
}

}  // namespace grtx
