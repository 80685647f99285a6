// SPDX-License-Identifier: Apache-2.0
// Enumerations with names: one table per enumeration, next to it, for configuration, command line, files and messages.
//
//   enum class Order : std::uint8_t { fifo, lifo };
//   constexpr auto enum_names(Order) { return names_in_order<Order>({"fifo", "lifo"}); }
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

/// Makes the table of an enumeration with the values 0, 1, 2 ... from their names in that order.
template <typename Enum, std::size_t count>
constexpr std::array<EnumName<Enum>, count> names_in_order(const std::string_view (&names)[count]) {
  std::array<EnumName<Enum>, count> table{};
  for (std::size_t i = 0; i < count; ++i) table[i] = {static_cast<Enum>(i), names[i]};
  return table;
}

/// An enumeration with a table, returned by enum_names(Enum) in the enumeration's namespace.
template <typename Enum>
concept NamedEnum = std::is_enum_v<Enum> && requires(Enum value) {
  enum_names(value);
};

/// The name of a value; "?" if it is not in the table.
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

/// Number of values: the size of an array indexed by the enumeration, if its values are 0, 1, 2 ...
template <NamedEnum Enum>
inline constexpr std::size_t kCountOf = enum_names(Enum{}).size();

/// The name of the value with index `place` in such an array.
template <NamedEnum Enum>
constexpr std::string_view name_at(std::size_t place) {
  return enum_names(Enum{})[place].name;
}

/// All names, in the order of the table.
template <NamedEnum Enum>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const EnumName<Enum>& entry : enum_names(Enum{})) names.emplace_back(entry.name);
  return names;
}

/// The names as "a, b, c".
std::string joined_names(const std::vector<std::string>& names);

/// Error text for a name that is not in `known`: lists the known names and suggests the nearest.
std::string unknown_name(std::string_view name, const std::vector<std::string>& known);

/// Like from_name(), but throws Error{file, place, unknown_name()} for an unknown name.
template <NamedEnum Enum>
Enum value_of(std::string_view name, const std::string& file, const std::string& place) {
  const std::optional<Enum> value = from_name<Enum>(name);
  if (!value) throw Error(file, place, unknown_name(name, names_of<Enum>()));
  return *value;
}

}  // namespace grtx
