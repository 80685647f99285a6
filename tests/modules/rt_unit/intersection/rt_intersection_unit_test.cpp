// SPDX-License-Identifier: Apache-2.0
// Intersection unit: exact start and result cycles for count, latency and interval, in queue order.
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"

#include "grtx/base/error.h"

#include <gtest/gtest.h>

#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

class RtIntersectionUnitTest : public SystemCTest {};

/// Stands for the RT scheduler.
struct Results final : intersection_client_if {
  std::vector<std::pair<Cycle, LaneId>> seen;
  void unit_result(Cycle now, LaneId id) override { seen.emplace_back(now, id); }
};

struct UnitCase {
  const char* what;
  IntersectionUnit::Config config;
  std::vector<unsigned> tests;  ///< of the operations queued in cycle 0
  std::vector<std::pair<Cycle, LaneId>> results;
};

struct PortCase {
  const char* what;
  TestInput input;
  std::vector<std::vector<LaneId>> nodes;  ///< lanes of each, queued in cycle 0
  std::vector<std::pair<Cycle, LaneId>> results;
};

// Eight pipelines read eight rays and eight nodes in a cycle, from memories with one port.
TEST_F(RtIntersectionUnitTest, PipelinesStartWhatCanBeReadInACycle) {
  const std::vector<PortCase> cases = {
      {"no limit", {}, {{0, 2}, {4, 6}}, {{2, 0}, {2, 2}, {2, 4}, {2, 6}}},
      {"banks", {0, 8, 2, 0}, {{0, 1, 2, 3, 5}}, {{2, 0}, {2, 1}, {3, 2}, {3, 3}, {4, 5}}},
      {"all in one bank", {0, 8, 2, 0}, {{0, 2, 4}}, {{2, 0}, {3, 2}, {4, 4}}},
      {"a node a cycle", {0, 8, 0, 1}, {{0, 1, 2}, {3}, {4, 5}}, {{2, 0}, {2, 1}, {2, 2}, {3, 3}, {4, 4}, {4, 5}}},
      {"two nodes", {0, 8, 0, 2}, {{0, 1}, {3}, {4, 5}}, {{2, 0}, {2, 1}, {2, 3}, {3, 4}, {3, 5}}},
      {"both", {0, 8, 4, 1}, {{0, 1, 4}, {2}}, {{2, 0}, {2, 1}, {3, 4}, {4, 2}}},
  };
  for (const PortCase& c : cases) {
    SCOPED_TRACE(c.what);
    fresh_context();
    IntersectionUnit unit("unit", {8, 1, 1}, 1, ray_triangle_path(), c.input);
    Results results;
    unit.client.bind(results);
    elaborate();
    for (const auto& node : c.nodes) {
      unit.begin_node();
      for (const LaneId lane : node) unit.enqueue(0, lane, 1);
    }
    for (Cycle now = 1; !unit.idle() && now < 100; now = unit.due()) unit.tick(now);
    EXPECT_EQ(results.seen, c.results);
  }
}

TEST_F(RtIntersectionUnitTest, ResultsComeInTheCycleOfTheFormula) {
  const std::vector<UnitCase> cases = {
      {"one pipeline", {1, 13, 1}, {1, 1, 1}, {{14, 0}, {15, 1}, {16, 2}}},
      {"interval", {1, 13, 3}, {1, 1, 1}, {{14, 0}, {17, 1}, {20, 2}}},
      {"two pipelines", {2, 4, 1}, {1, 1, 1, 1}, {{5, 0}, {5, 1}, {6, 2}, {6, 3}}},
      {"two pipelines, interval", {2, 4, 2}, {1, 1, 1, 1}, {{5, 0}, {5, 1}, {7, 2}, {7, 3}}},
      {"latency 1", {4, 1, 1}, {1, 1}, {{2, 0}, {2, 1}}},
      // Lane 0 holds its pipeline for six starts; lanes 2 and 3 follow lane 1 and overtake it.
      {"several tests", {2, 4, 1}, {6, 1, 1, 2}, {{5, 1}, {6, 2}, {8, 3}, {10, 0}}},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    fresh_context();
    IntersectionUnit unit("unit", c.config, 1, ray_triangle_path());
    Results results;
    unit.client.bind(results);
    elaborate();
    for (std::size_t i = 0; i < c.tests.size(); ++i) unit.enqueue(0, static_cast<LaneId>(i), c.tests[i]);
    for (Cycle now = 1; !unit.idle() && now < 100;) {
      unit.tick(now);
      const Cycle next = unit.due();
      EXPECT_GT(next, now);
      now = next;  // nothing may be missed by jumping
    }
    EXPECT_EQ(results.seen, c.results);
    std::uint64_t tests = 0;
    for (const unsigned t : c.tests) tests += t;
    EXPECT_EQ(unit.counters().operations, c.tests.size());
    EXPECT_EQ(unit.counters().tests, tests);
    EXPECT_EQ(unit.counters().busy_cycles, tests * c.config.interval);
  }
}

TEST_F(RtIntersectionUnitTest, OperatorsScaleWithPipelines) {
  const IntersectionUnit unit("unit", {4, 13, 1}, 8, ray_box_path(6));
  const auto operators = unit.inventory().operators;
  ASSERT_EQ(operators.size(), 4u);
  EXPECT_EQ(operators[0].count, 4u * 36u);  // six slab tests of six additions
  EXPECT_EQ(operators[3].count, 4u * 12u);  // twelve exchanges order six children
}

TEST_F(RtIntersectionUnitTest, QuantisedBoxesAreDecodedFirst) {
  const auto plain = ray_box_path(8).operators, decoding = ray_box_path(8, true).operators;
  ASSERT_EQ(decoding.size(), plain.size() + 3);
  EXPECT_EQ(decoding[4].name, "mux");
  EXPECT_EQ(decoding[4].count, 4u * 48u);  // a shifter of four stages for each of 48 bounds
  EXPECT_EQ(decoding[5].name, "int_add");
  EXPECT_EQ(decoding[5].count, 48u);
  EXPECT_EQ(decoding[6].name, "fp_add");
  EXPECT_EQ(decoding[6].count, 48u);
}

TEST_F(RtIntersectionUnitTest, ZeroIsNoCountLatencyOrInterval) {
  EXPECT_THROW(IntersectionUnit("a", {0, 1, 1}, 1, {}), Error);
  EXPECT_THROW(IntersectionUnit("b", {1, 0, 1}, 1, {}), Error);
  EXPECT_THROW(IntersectionUnit("c", {1, 1, 0}, 1, {}), Error);
}

}  // namespace
}  // namespace grtx::modules
