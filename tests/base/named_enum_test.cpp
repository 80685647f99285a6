// SPDX-License-Identifier: Apache-2.0
// Enumerations with a name table: names and values go both ways, and an unknown name lists the known ones.
#include "grtx/base/declare/named_enum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace grtx {
namespace {

enum class Fruit : std::uint8_t { apple, plum, unnamed };
constexpr auto enum_names(Fruit) {
  using enum Fruit;
  return std::to_array<EnumName<Fruit>>({{plum, "plum"}, {apple, "apple"}});
}

TEST(NamedEnum, NamesAndValuesGoBothWays) {
  static_assert(name_of(Fruit::plum) == "plum");
  static_assert(from_name<Fruit>("apple") == Fruit::apple);
  EXPECT_EQ(from_name<Fruit>("pear"), std::nullopt);
  EXPECT_EQ(from_name<Fruit>(""), std::nullopt);
  EXPECT_EQ(name_of(Fruit::unnamed), "?");
  EXPECT_EQ(names_of<Fruit>(), (std::vector<std::string>{"plum", "apple"}));
}

enum class Order : std::uint8_t { fifo, lifo };
constexpr auto enum_names(Order) { return names_in_order<Order>({"fifo", "lifo"}); }

TEST(NamedEnum, ATableInTheOrderOfTheValues) {
  static_assert(kCountOf<Order> == 2);
  static_assert(name_of(Order::lifo) == "lifo" && name_at<Order>(0) == "fifo");
  EXPECT_EQ(from_name<Order>("lifo"), Order::lifo);
}

TEST(NamedEnum, AnUnknownNameListsTheKnownAndTheNearest) {
  EXPECT_EQ(value_of<Fruit>("apple", "file", "line 3"), Fruit::apple);
  try {
    value_of<Fruit>("appel", "file", "line 3");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), "file");
    EXPECT_EQ(error.place(), "line 3");
    EXPECT_EQ(error.rule(), "must be one of plum, apple, not 'appel'; the nearest is 'apple'");
  }
}

}  // namespace
}  // namespace grtx
