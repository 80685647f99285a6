// SPDX-License-Identifier: Apache-2.0
// Machine `vulkan-sim` takes the cycles of Vulkan-Sim itself for each kind of visit that hits the L1. Its replay of 100
// and of 300 equal reads by one lane says which (docs/results/vulkan-sim.md).
#include "rtl_tlm/rt_unit/directed.h"

#include "paths.h"

namespace grtx::sim {
namespace {

using namespace test;

Cycle cycles(const Directed& d) {
  const traces::testing::TemporaryFile file("vulkan_sim_machine");
  traces::Header header = d.header;
  header.groups = d.groups.size();
  traces::testing::write_trace(file.path(), header, d.groups);
  traces::check(traces::Reader(file.path()), true);
  ChildProcess child("simulation", [&] {
    set_machines_folder(grtx::paths::source_dir() + "/configs/machines");
    const GpuConfig config = load_config("vulkan-sim", {"gpu.sms=1", "l1.perfect=true"});
    const SimulationResult result = test::simulate_priced(file.path(), config, {});
    EXPECT_EQ(result.violations, std::vector<std::string>{});
    return result.document.at("stats").dump();
  });
  return value(ordered_json::parse(child.result()), "gpu.cycles");
}

// 14 at the first comparison, with an L1 of two cycles and a unit of eight: stages and definitions, no work.
TEST(VulkanSimMachine, ABoxNodeThatHitsTakesNineCyclesNotFourteen) {
  const auto chained = [](unsigned length) {
    Directed d = directed(8, 1);
    add_round(d.groups[0].rays[0], chain(d.groups[0], length, LeafOutcome::miss));
    return cycles(d);
  };
  EXPECT_EQ(chained(30) - chained(10), 20 * 9);
}

// 10 when the descriptor was one more sector of the leaf's own fetch.
TEST(VulkanSimMachine, ALeafBehindItsDescriptorTakesThirteenCyclesNotTen) {
  const auto leaves = [](unsigned count) {
    Directed d = directed(8, 1);
    d.groups[0].nodes = {node(1, 2, 6, NodeKind::triangle)};
    std::vector<Event> events = {internal_event(0, (1U << count) - 1)};
    for (unsigned i = 0; i < count; ++i) events.push_back(leaf_event(2 + i, LeafOutcome::miss));
    add_round(d.groups[0].rays[0], events);
    return cycles(d);
  };
  EXPECT_EQ(leaves(6) - leaves(2), 4 * 13);
}

// The leaf's four sectors and its test, then the header's two and the way into the BLAS, whose root is a box node.
TEST(VulkanSimMachine, AnInstanceAndItsHeaderTakeSixteenCycles) {
  const auto instances = [](unsigned count) {
    Directed d = directed(8, 1);
    d.header = small_header("tlas-tri20");
    d.header.k = 8;
    d.header.width = 32;
    d.header.height = 1;
    d.header.warp_mapping = traces::WarpMapping::linear;
    const auto blas_root = static_cast<std::uint32_t>(d.header.blas_root / traces::kNodeUnit);
    d.groups[0].nodes = {node(1, 2, 6, NodeKind::instance), node(blas_root, blas_root + 1, 1, NodeKind::triangle)};
    std::vector<Event> events = {internal_event(0, (1U << count) - 1)};
    for (unsigned i = 0; i < count; ++i) {
      events.push_back(instance_event(2 + 2 * i));
      events.push_back(internal_event(1, 0));
    }
    add_round(d.groups[0].rays[0], events);
    return cycles(d);
  };
  EXPECT_EQ(instances(6) - instances(2), 4 * (16 + 9));
}

}  // namespace
}  // namespace grtx::sim
