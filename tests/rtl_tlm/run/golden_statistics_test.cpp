// SPDX-License-Identifier: Apache-2.0
// Whole runs give the statistics on record, to the last count: a change that is meant to make the model faster must not
// change what it says. A change that is meant to alter timing writes the table anew and says so:
//   GRTX_WRITE_GOLDEN=tests/rtl_tlm/run/golden.tsv rtl_tlm_tests --gtest_filter='*Golden*'
#include <gtest/gtest.h>

#include <cstdlib>

#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/rtl_tlm/run/statistics_table.h"
#include "paths.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using traces::testing::RandomOptions;

struct Case {
  const char* name;
  bool two_level;
  bool checkpoint;
  std::uint64_t capacity;
  const char* order;
  std::vector<std::string> settings;
  unsigned k = 4;
  const char* design = nullptr;  ///< whose units these are, and whose leaves: procedural
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"baseline", false, false, 0, "fifo", {}},
      {"sw", true, false, 0, "fifo", {}},
      {"hw", false, true, 1000, "fifo", {}},
      {"grtx", true, true, 1000, "fifo", {}},
      {"overflow", true, true, 6, "lifo", {}},
      {"nearest", false, true, 1000, "nearest", {"rt.checkpoint.write_combine=true", "rt.checkpoint.read_buffer=true"}},
      {"no_prefetch", false, false, 0, "fifo", {"rt.prefetch.enabled=false", "rt.memory.merge_in_flight=false"}},
      {"round_robin", true, true, 1000, "fifo", {"rt.scheduler.policy=round_robin", "rt.box.per_child=true"}},
      {"perfect", true, false, 0, "fifo", {"l1.perfect=true", "dram.perfect=true"}},
      {"tight",
       true,
       true,
       1000,
       "fifo",
       {"l1.link_capacity=1", "crossbar.link_capacity=1", "l1.mshr_entries=4", "l2.mshr_entries=4", "dram.queue=4"}},
      {"odd",
       false,
       true,
       1000,
       "fifo",
       {"l2.slices=3", "l2.bytes=61440", "l1.banks=1", "simt.message_latency=7", "l1.link_latency=3"}},
      {"gautracer", false, false, 0, "fifo", {}, 16, "gautracer"},
      {"walk", false, false, 0, "fifo", {}, 64, "walk", traces::NodeLayout::quantised},
  };
  return all;
}

/// name -> value of all statistics that do not depend on the host.
ordered_json values(const std::string& path, const std::vector<std::string>& settings) {
  ChildProcess child("simulation", [&] {
    SimulationOptions options;
    options.quiet = true;
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", settings);
    return test::simulate_priced(path, config, options).document.at("stats").dump();
  });
  ordered_json all;
  const ordered_json stats = ordered_json::parse(child.result());
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with("host.")) all[name] = entry.at("value");
  }
  return all;
}

class GoldenStatistics : public ::testing::TestWithParam<Case> {};

TEST_P(GoldenStatistics, AreReproduced) {
  const Case& c = GetParam();
  RandomOptions random;
  random.seed = 11;
  random.groups = 20;
  random.warp_size = 32;
  random.two_level = c.two_level;
  random.checkpoint = c.checkpoint;
  random.capacity = c.capacity;
  random.checkpoint_order = *from_name<traces::CheckpointOrder>(c.order);
  random.k = c.k;
  std::vector<std::string> settings = c.settings;
  if (c.design != nullptr) {
    const explore::Design& design = explore::design_of(c.design);
    for (const auto& [key, value] : explore::keys_for(design, c.k)) settings.push_back(key + "=" + value);
  }
  random.layout = c.layout;
  random.procedural = c.layout == traces::NodeLayout::quantised;  // whose two kinds of leaves differ in size
  const traces::testing::TemporaryFile file(c.name);
  auto trace = traces::testing::random_trace(random);
  for (traces::RayGroup& group : trace.groups) group.kind = traces::RayKind::primary;  // one launch
  if (c.design != nullptr) test::make_procedural(trace);
  traces::testing::write_trace(file.path(), trace.header, trace.groups);

  const ordered_json found = values(file.path(), settings);
  if (const char* const path = std::getenv("GRTX_WRITE_GOLDEN")) {
    StatisticsTable golden(path);
    golden.put(c.name, found);
    write_file(path, golden.text());
    GTEST_SKIP() << "wrote " << c.name << " into " << path;
  }
  const StatisticsTable golden(grtx::paths::source_dir() + "/tests/rtl_tlm/run/golden.tsv");
  ASSERT_TRUE(golden.has(c.name)) << "no record";
  const ordered_json expected = golden.values_of(c.name);
  for (const auto& [name, value] : expected.items()) {
    ASSERT_TRUE(found.contains(name)) << name << " is missing";
    EXPECT_EQ(found.at(name), value) << name;
  }
  // A statistic that is new belongs into the record too.
  for (const auto& [name, value] : found.items()) EXPECT_TRUE(expected.contains(name)) << name << " is not on record";
}

INSTANTIATE_TEST_SUITE_P(Cases, GoldenStatistics, ::testing::ValuesIn(cases()),
                         [](const auto& test_case) { return std::string(test_case.param.name); });

}  // namespace
}  // namespace grtx::sim
