// SPDX-License-Identifier: Apache-2.0
// Which unit a statistic belongs to, and which unit moved first.
#include "grtx/rtl_tlm/regress/statistics_difference.h"

#include <gtest/gtest.h>

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

TEST(StatisticsDifference, EachStatisticBelongsToAUnitOfTheBlockDiagram) {
  const struct {
    const char *statistic, *unit;
  } cases[] = {{"gpu.distributor.groups", "work distributor"},
               {"gpu.sm0.warps", "work distributor"},
               {"gpu.sm0.rt.selections", "RT scheduler and warp buffer"},
               {"gpu.simt.warps", "SIMT core"},
               {"gpu.rt.stall.memory", "RT scheduler and warp buffer"},
               {"gpu.rt.node_fetch_latency", "memory scheduler"},
               {"gpu.rt.stack.spills", "stack unit"},
               {"gpu.rt.prefetch.nodes", "prefetchers"},
               {"gpu.rt.ray_box.tests", "ray-box unit"},
               {"gpu.rt.any_hit.batches", "any-hit collector"},
               {"gpu.rt.checkpoint.entries_read", "checkpoint unit"},
               {"gpu.l1.node.hits", "L1 data cache"},
               {"gpu.l2.accesses", "L2"},
               {"gpu.dram.bytes", "DRAM"},
               {"gpu.cycles", "whole machine"},
               {"gpu.energy_nj.rt", "energy"},
               {"gpu.bound.issue", "lower bounds"},
               {"a.users.own", "whole machine"}};
  for (const auto& c : cases) EXPECT_STREQ(unit_of_statistic(c.statistic).name, c.unit) << c.statistic;
}

ordered_json document(const std::vector<std::pair<std::string, double>>& values) {
  ordered_json stats;
  for (const auto& [name, value] : values) {
    stats[name] = {{"value", value}, {"unit", is_time(name, "") ? "cycles" : "requests"}};
  }
  return {{"stats", stats}};
}

std::string first(const std::vector<std::pair<std::string, double>>& record,
                  const std::vector<std::pair<std::string, double>>& found) {
  const StatisticsComparison comparison = compare_statistics({}, document(record), document(found));
  const StatisticDifference* moved = likely_origin(comparison);
  return moved == nullptr ? "" : moved->name;
}

TEST(StatisticsDifference, WorkMovesWithTheFlowAndWaitingAgainstIt) {
  // L1 accesses are the same, its misses are not: the L1 did more, and what lies below followed.
  EXPECT_EQ(first({{"gpu.dram.bytes", 4}, {"gpu.l1.fills", 2}, {"gpu.l1.accesses", 9}, {"gpu.cycles", 50}},
                  {{"gpu.dram.bytes", 6}, {"gpu.l1.fills", 3}, {"gpu.l1.accesses", 9}, {"gpu.cycles", 60}}),
            "gpu.l1.fills");
  // Nobody did more: the DRAM is slower, and all above it wait.
  EXPECT_EQ(first({{"gpu.l1.miss_latency", 4}, {"gpu.dram.access_latency", 2}, {"gpu.cycles", 50}},
                  {{"gpu.l1.miss_latency", 6}, {"gpu.dram.access_latency", 4}, {"gpu.cycles", 60}}),
            "gpu.dram.access_latency");
  EXPECT_EQ(first({{"gpu.cycles", 50}}, {{"gpu.cycles", 60}}), "gpu.cycles");
  EXPECT_EQ(first({{"gpu.cycles", 50}}, {{"gpu.cycles", 50}}), "");
}

TEST(StatisticsDifference, TheUnitOfTheChangedKeyMovedFirst) {
  const auto moved = [](const char* key) {
    auto record = document({{"gpu.simt.any_hit.batches", 4}, {"gpu.l2.miss_latency", 2}, {"gpu.cycles", 50}});
    auto found = document({{"gpu.simt.any_hit.batches", 5}, {"gpu.l2.miss_latency", 3}, {"gpu.cycles", 60}});
    record["config"] = {{key, 1}};
    found["config"] = {{key, 2}};
    const StatisticsComparison comparison = compare_statistics({}, record, found);
    return likely_origin(comparison)->name;
  };
  EXPECT_EQ(moved("l2.latency"), "gpu.l2.miss_latency");  // later hits make more batches time out
  EXPECT_EQ(moved("gpu.core_mhz"), "gpu.cycles");
  EXPECT_EQ(moved("simt.registers"), "gpu.simt.any_hit.batches");
  EXPECT_EQ(moved("dram.banks"), "gpu.simt.any_hit.batches");  // nothing of the DRAM is on record: by the flow
  EXPECT_EQ(moved("own.key"), "gpu.simt.any_hit.batches");     // of no unit
}

TEST(StatisticsDifference, ZeroAndNullAreCompared) {
  const auto value = [](const ordered_json& v) {
    return ordered_json{{"stats", {{"a", {{"value", v}, {"unit", ""}}}}}};
  };
  RegressionCase loose;
  loose.tolerances = {{"*", 0.5, ""}};
  EXPECT_TRUE(compare_statistics(loose, value(nullptr), value(nullptr)).equal());
  EXPECT_FALSE(compare_statistics(loose, value(nullptr), value(0)).equal());
  EXPECT_FALSE(compare_statistics(loose, value(0), value(1)).equal());  // half of nothing
  EXPECT_TRUE(compare_statistics(loose, value(2), value(3)).equal());
  EXPECT_TRUE(compare_statistics({}, value(2), value(2.0)).equal());
}

}  // namespace
}  // namespace grtx::sim
