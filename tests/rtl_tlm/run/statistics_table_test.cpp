// SPDX-License-Identifier: Apache-2.0
// The table of records: what is put in comes out, as text that does not depend on the order, one line per statistic.
#include "grtx/rtl_tlm/run/statistics_table.h"

#include <gtest/gtest.h>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

constexpr const char* kText =
    "statistic\tcycle\tother\n"
    "config.name\t\"a\\tb\"\ttrue\n"
    "gpu.cycles\t18446744073709551615\t7\n"
    "gpu.rate\t0.1480700976042591\t\n"
    "gpu.share\tnull\t75.27182234600001\n";

StatisticsTable written() {
  StatisticsTable table;
  table.put("other", {{"gpu.share", 75.27182234600001}, {"gpu.cycles", 1}});
  table.put("cycle", {{"gpu.share", nullptr},
                      {"gpu.cycles", 18446744073709551615U},
                      {"config.name", "a\tb"},
                      {"gpu.rate", 0.1480700976042591}});
  table.put("other", {{"gpu.share", 75.27182234600001}, {"gpu.cycles", 7}, {"config.name", true}});
  return table;
}

TEST(StatisticsTable, IsALineAStatisticSortedByName) { EXPECT_EQ(written().text(), kText); }

TEST(StatisticsTable, ReadsWhatItWrote) {
  const traces::testing::TemporaryFile file("statistics_table");
  write_file(file.path(), kText);
  const StatisticsTable table(file.path());
  EXPECT_EQ(table.text(), kText);
  EXPECT_TRUE(table.has("other"));
  EXPECT_FALSE(table.has("windows"));
  EXPECT_EQ(table.values_of("other"),
            ordered_json({{"config.name", true}, {"gpu.cycles", 7}, {"gpu.share", 75.27182234600001}}));
  EXPECT_EQ(table.values_of("cycle").at("config.name"), "a\tb");
  EXPECT_TRUE(table.values_of("cycle").at("gpu.share").is_null());
}

TEST(StatisticsTable, AFileThatIsNotThereIsEmpty) {
  EXPECT_EQ(StatisticsTable("/nowhere/records.tsv").text(), "statistic\n");
}

TEST(StatisticsTable, WhatIsNoTableIsNamedByItsLine) {
  const struct {
    const char *text, *place;
  } cases[] = {{"", "line 1"},
               {"statistic\n", "line 1"},
               {"name\ta\n", "line 1"},
               {"statistic\ta\ta\n", "line 1"},
               {"statistic\ta\nx\t1", "line 2"},
               {"statistic\ta\nx\t1\t2\n", "line 2"},
               {"statistic\ta\nx\t1\nx\t2\n", "line 3"},
               {"statistic\ta\nx\tone\n", "line 2"},
               {"statistic\ta\nx\t[1]\n", "line 2"}};
  for (const auto& c : cases) {
    const traces::testing::TemporaryFile file("statistics_table");
    write_file(file.path(), c.text);
    try {
      StatisticsTable table(file.path());
      ADD_FAILURE() << c.text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(c.place), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace grtx::sim
