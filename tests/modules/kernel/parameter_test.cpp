// SPDX-License-Identifier: Apache-2.0
// One parameter: what may be assigned, how a refusal reads, and how units' lists are put together under prefixes.
#include "grtx/modules/kernel/declare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

enum class Colour : std::uint8_t { red, green };
constexpr auto enum_names(Colour) { return names_in_order<Colour>({"red", "green"}); }

struct Part {
  unsigned count = 4;
  double share = 0.5;
  bool on = false;
  Colour colour = Colour::red;
  std::string policy = "first";
  void parameters(ParameterList& list) {
    list.add("count", count, {1, 64}, "things", "how many", kTable1);
    list.add("share", share, {0, 1}, "", "how much", assumed("a guess"));
    list.add("on", on, "a switch", kOurs);
    list.add("colour", colour, "an enumeration", kOurs);
    list.add("policy", policy, {"first", "last"}, "a registered name", kOurs);
    list.rule(
        "count", [this] { return 64 % count == 0; }, "must divide 64");
  }
};

struct Whole {
  Part a, b;
  void parameters(ParameterList& list) {
    list.part("a", a);
    list.under("b", [&](ParameterList& keys) { keys.part("inner", b); });
  }
};

class Parameters : public ::testing::Test {
 protected:
  Parameters() { whole.parameters(list); }
  const Parameter& key(const std::string& name) const {
    for (const Parameter& p : list.items()) {
      if (p.name == name) return p;
    }
    throw std::out_of_range(name);
  }
  Whole whole;
  ParameterList list;
};

TEST_F(Parameters, TheEndsOfARangeAreTakenAndWhatIsBeyondIsNot) {
  for (const char* taken : {"1", "64"}) EXPECT_EQ(assign_text(key("a.count"), taken), "") << taken;
  for (const char* refused : {"0", "65"}) EXPECT_NE(assign_text(key("a.count"), refused), "") << refused;
  for (const char* taken : {"0.0", "1.0"}) EXPECT_EQ(assign_text(key("a.share"), taken), "") << taken;
  for (const char* refused : {"-0.001", "1.001"}) EXPECT_NE(assign_text(key("a.share"), refused), "") << refused;
  unsigned wide = 0;
  ParameterList unlimited;
  unlimited.add("wide", wide, {}, "", "no limit but the type's", kOurs);
  EXPECT_EQ(assign_text(unlimited.items().front(), "4294967295"), "");
  EXPECT_EQ(wide, 4294967295U);
  EXPECT_NE(assign_text(unlimited.items().front(), "4294967296"), "");
}

TEST_F(Parameters, PartsStandUnderTheirPrefixesInOrder) {
  std::vector<std::string> names;
  for (const Parameter& p : list.items()) names.push_back(p.name);
  EXPECT_EQ(names, (std::vector<std::string>{"a.count", "a.share", "a.on", "a.colour", "a.policy", "b.inner.count",
                                             "b.inner.share", "b.inner.on", "b.inner.colour", "b.inner.policy"}));
}

TEST_F(Parameters, AnAssignmentReachesTheConfigOfItsPart) {
  EXPECT_EQ(assign_text(key("b.inner.count"), "7"), "");
  EXPECT_EQ(assign_text(key("b.inner.share"), "0.25"), "");
  EXPECT_EQ(assign_text(key("b.inner.on"), "true"), "");
  EXPECT_EQ(assign_text(key("b.inner.colour"), "green"), "");
  EXPECT_EQ(assign_text(key("b.inner.policy"), "last"), "");
  EXPECT_EQ(whole.b.count, 7U);
  EXPECT_EQ(whole.b.share, 0.25);
  EXPECT_TRUE(whole.b.on);
  EXPECT_EQ(whole.b.colour, Colour::green);
  EXPECT_EQ(whole.b.policy, "last");
  EXPECT_EQ(whole.a.count, 4U);
  EXPECT_EQ(value_text(key("b.inner.colour")), "green");
}

TEST_F(Parameters, ARefusalNamesTheRuleAndLeavesTheValue) {
  EXPECT_EQ(assign_text(key("a.count"), "65"), "must be 1 to 64, not 65");
  EXPECT_EQ(assign_text(key("a.count"), "0"), "must be 1 to 64, not 0");
  EXPECT_EQ(assign_text(key("a.count"), "2.5"), "must be an integer (1 to 64), not the number 2.5");
  EXPECT_EQ(assign_text(key("a.share"), "1.5"), "must be 0 to 1, not 1.5");
  EXPECT_EQ(assign_text(key("a.on"), "yes"), "must be true or false (true, false), not 'yes'");
  EXPECT_EQ(assign_text(key("a.colour"), "gren"), "must be one of red, green, not 'gren'; the nearest is 'green'");
  EXPECT_EQ(assign_text(key("a.policy"), "lst"), "must be one of first, last, not 'lst'; the nearest is 'last'");
  EXPECT_EQ(value_text(key("a.count")), "4");
  EXPECT_EQ(value_text(key("a.colour")), "red");
}

TEST(RequireAllowed, NamesTheKeyOfAUnitThatWasBuiltWithoutAFile) {
  Part part;
  EXPECT_NO_THROW(require_allowed("rt.part", part));
  part.count = 65;
  try {
    require_allowed("rt.part", part);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), "configuration");
    EXPECT_EQ(error.place(), "rt.part.count");
    EXPECT_EQ(error.rule(), "must be 1 to 64, not 65");
  }
}

TEST(RequireAllowed, AsksRulesOfValuesThatAreInRange) {
  Part part;
  const auto fault = [&part] {
    try {
      require_allowed("rt.part", part);
    } catch (const Error& error) {
      return error.place() + ": " + error.rule();
    }
    return std::string();
  };
  part.count = 0;  // which the rule would divide by
  EXPECT_EQ(fault(), "rt.part.count: must be 1 to 64, not 0");
  part.count = 3;
  EXPECT_EQ(fault(), "rt.part.count: must divide 64");
  part.count = 4;
  EXPECT_EQ(fault(), "");
}

TEST_F(Parameters, RulesOfPartsNameTheWholeKeyAndTheCallersOrigin) {
  EXPECT_NO_THROW(require_rules(list, "machine.toml"));
  whole.b.count = 5;
  try {
    require_rules(list, "machine.toml");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.file() + ": " + error.place(), "machine.toml: b.inner.count");
  }
}

TEST(RegistryTest, KeepsTheProjectsNamesFirstAndTakesEachOnce) {
  Registry<int> numbers("number", "a.number", {{"one", 1}, {"two", 2}});
  numbers.add("three", 3);
  EXPECT_EQ(numbers.names(), (std::vector<std::string>{"one", "two", "three"}));
  EXPECT_EQ(numbers.at("three"), 3);
  EXPECT_THROW(numbers.add("one", 4), std::logic_error);
  EXPECT_EQ(numbers.at("one"), 1);
  try {
    numbers.at("tow");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.place(), "a.number");
    EXPECT_EQ(error.rule(), "must be one of one, two, three, not 'tow'; the nearest is 'two'");
  }
}

}  // namespace
}  // namespace grtx::modules
