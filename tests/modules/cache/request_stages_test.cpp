// SPDX-License-Identifier: Apache-2.0
// Where a read spends its time: exact stages of single reads, and stages that add up to the whole of every read.
#include "grtx/modules/cache/request_stages.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "modules/cache/hierarchy_bench.h"

namespace grtx::modules {
namespace {

class RequestStagesTest : public SystemCTest {
 protected:
  void observe(HierarchyBench& bench) {
    for (auto& l1 : bench.l1) l1->observe(&stages);
    for (auto& l2 : bench.l2) l2->observe(&stages);
  }
  std::map<std::string, double> values() const {
    StatisticList list;
    stages.describe(list);
    std::map<std::string, double> by_name;
    for (const Statistic& s : list.items()) by_name[s.name] = s.number();
    return by_name;
  }
  RequestStages stages;
};

TEST_F(RequestStagesTest, OfAHitInL1AndL2AndOfAReadFromDram) {
  const HierarchyBench::Config config;
  HierarchyBench bench(config);
  observe(bench);
  MockClient &client = *bench.client[3], &elsewhere = *bench.client[10];
  const auto dram = client.read(100, 0x5000, Region::tlas);
  client.read(2000, 0x5000, Region::leaf);
  elsewhere.read(3000, 0x5000, Region::checkpoint);
  client.write(3500, 0x9000);  // nobody waits for a write
  EXPECT_TRUE(run_until_quiet(bench.core, 20000));
  std::map<std::string, double> v = values();
  EXPECT_EQ(v.at("gpu.latency.leaves.whole"), config.l1.latency);
  EXPECT_EQ(v.at("gpu.latency.leaves.l1"), config.l1.latency);
  EXPECT_EQ(v.at("gpu.latency.leaves.dram"), 0);
  const double l1 = config.l1.tag_latency + 1, crossbar = 2.0 * (1 + config.crossbar.latency);
  EXPECT_EQ(v.at("gpu.latency.checkpoints.l1"), l1);  // tags, and the link to the client
  EXPECT_EQ(v.at("gpu.latency.checkpoints.crossbar"), crossbar);
  EXPECT_EQ(v.at("gpu.latency.checkpoints.l2"), config.l2.latency);
  EXPECT_EQ(v.at("gpu.latency.checkpoints.whole"), 185);
  const double whole = static_cast<double>(client.answered(dram) - 100);
  EXPECT_EQ(v.at("gpu.latency.nodes.whole"), whole);
  EXPECT_EQ(v.at("gpu.latency.nodes.whole_p95"), whole);
  EXPECT_EQ(v.at("gpu.latency.nodes.dram"), whole - l1 - crossbar - config.l2.latency);
  EXPECT_FALSE(v.contains("gpu.latency.shading.reads"));
  EXPECT_EQ(stages.violation(), "");
}

// Another read of the sector comes while the first is under way: it has what is left of the stages.
TEST_F(RequestStagesTest, AMergedReadMeetsWhatIsLeft) {
  const HierarchyBench::Config config;
  HierarchyBench bench(config);
  observe(bench);
  MockClient& client = *bench.client[0];
  const Cycle at_l2 = 100 + config.l1.tag_latency + 1 + config.crossbar.latency;
  const auto first = client.read(100, 0x5000, Region::tlas), merged = client.read(at_l2 + 1, 0x5000, Region::stack);
  EXPECT_TRUE(run_until_quiet(bench.core, 20000));
  EXPECT_EQ(client.answered(merged), client.answered(first) + 1);  // one response a cycle
  std::map<std::string, double> v = values();
  EXPECT_EQ(v.at("gpu.latency.stacks.l2"), config.l2.latency - 1);
  EXPECT_EQ(v.at("gpu.latency.stacks.crossbar"), 1 + config.crossbar.latency);
  EXPECT_EQ(v.at("gpu.latency.stacks.dram"), v.at("gpu.latency.nodes.dram"));
  EXPECT_EQ(v.at("gpu.latency.stacks.l1"), 2);  // its turn at the port, and the link
}

TEST_F(RequestStagesTest, AddUpToEveryReadUnderContention) {
  HierarchyBench::Config config;
  config.sms = 3;
  config.l1.clients = 2;
  config.l1.geometry = {8192, 128, 32, 16};
  config.l2.geometry = {16384, 128, 32, 8};
  config.l1.mshr_entries = 12;
  config.l2.mshr_entries = 6;
  config.l2.queue = 4;
  config.dram.channel.queue = 4;
  HierarchyBench bench(config);
  observe(bench);
  for (unsigned i = 0; i < bench.client.size(); ++i) {
    Random random(i);
    Cycle cycle = 10;
    for (unsigned n = 0; n < 400; ++n) {
      cycle += random.below(4);
      MemoryRequest r{.address = random.below(1 << 11) * kSectorBytes,
                      .region = static_cast<Region>(random.below(kRegionCount)),
                      .write = random.chance(20)};
      r.prefetch = !r.write && random.chance(10);
      bench.client[i]->at(cycle, r);
    }
    bench.client[i]->takes = [i](Cycle now) { return Random(i + now * 17).chance(70); };
  }
  run(bench.core, 60000);
  bench.expect_conserved();
  EXPECT_EQ(stages.violation(), "");
  std::uint64_t reads = 0;
  double queued = 0.0;
  for (const auto& c : bench.client) {
    for (const auto& a : c->answers()) reads += !a.response.write && !a.response.prefetch ? 1 : 0;
  }
  double counted = 0.0;
  const std::map<std::string, double> v = values();
  for (const std::string_view kind : names_of<ReadKind>()) {
    const std::string of = "gpu.latency." + std::string(kind);
    counted += v.at(of + ".reads");
    queued += v.at(of + ".queue");
    double parts = 0.0;
    for (const std::string_view stage : names_of<MemoryStage>()) parts += v.at(of + "." + std::string(stage));
    EXPECT_NEAR(parts, v.at(of + ".whole"), 1e-9 * parts) << kind;
    EXPECT_GE(v.at(of + ".whole_p95"), v.at(of + ".whole")) << kind;
  }
  EXPECT_EQ(counted, static_cast<double>(reads));
  EXPECT_GT(queued, 0.0);
}

TEST(StageCycles, AreExactUpToTheirLastBin) {
  StageCycles cycles;
  for (std::uint64_t n = 1; n <= 100; ++n) cycles.add(n);
  EXPECT_EQ(cycles.percentile(0.95), 95U);
  EXPECT_DOUBLE_EQ(cycles.mean(), 50.5);
  for (int i = 0; i < 10; ++i) cycles.add(100000);
  EXPECT_EQ(cycles.percentile(0.95), 100000U);
  EXPECT_EQ(StageCycles().percentile(0.95), 0U);
}

}  // namespace
}  // namespace grtx::modules
