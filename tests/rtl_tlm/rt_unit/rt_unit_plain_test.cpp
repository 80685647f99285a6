// The SystemC RT unit against the plain one (tests/rtl_tlm/plain), cycle by cycle: every retirement, any-hit batch and
// memory request.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>

#include "rtl_tlm/rt_unit/plain_rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim {
namespace {

using namespace test;
using traces::testing::random_trace;
using traces::testing::RandomOptions;

/// Compares two event lists and names the first difference.
template <typename T, typename Print>
void expect_same(const char* what, const std::vector<T>& plain, const std::vector<T>& systemc, Print&& print) {
  const std::size_t common = std::min(plain.size(), systemc.size());
  for (std::size_t i = 0; i < common; ++i) {
    if (plain[i] == systemc[i]) continue;
    ADD_FAILURE() << what << " " << i << ": plain " << print(plain[i]) << ", SystemC " << print(systemc[i]);
    return;
  }
  EXPECT_EQ(plain.size(), systemc.size()) << what;
}

void expect_agreement(const traces::Header& header, const std::vector<traces::RayGroup>& groups, BenchOptions options) {
  options.resident_warps = std::max<std::size_t>(options.resident_warps, groups.size());
  RtBench bench(header, options);
  PlainRtBench plain(header, options);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool any = std::any_of(groups[g].rays.begin(), groups[g].rays.end(),
                                 [](const traces::Ray& ray) { return !ray.rounds.empty(); });
    if (!any) continue;
    bench.launch(groups[g], static_cast<std::uint16_t>(g));
    plain.launch(groups[g], static_cast<unsigned>(g));
  }
  bench.run(50'000'000);
  plain.run(50'000'000);
  std::vector<PlainRtBench::Done> dones;
  for (const auto& d : bench.dones) dones.push_back({d.slot, d.round, d.cycle});
  std::vector<PlainRtBench::Batch> batches;
  for (const auto& b : bench.batches) batches.push_back({b.batch.slot, b.batch.round, b.batch.lanes, b.cycle});
  using fmt::format;
  for (unsigned c = 0; c < 4; ++c) {
    std::vector<PlainRtBench::Request> requests;
    for (const auto& r : bench.requests[c]) requests.push_back({r.request.address, r.request.write, r.cycle});
    const char* names[] = {"node request", "checkpoint request", "prefetch request", "stack request"};
    expect_same(names[c], plain.requests[c], requests, [](const PlainRtBench::Request& r) {
      return format("cycle {} {} {:#x}", r.cycle, r.write ? "write" : "read", r.address);
    });
  }
  expect_same("any-hit batch", plain.batches, batches, [](const PlainRtBench::Batch& b) {
    return format("cycle {} slot {} round {} lanes {:#x}", b.cycle, b.slot, b.round, b.lanes);
  });
  expect_same("retirement", plain.dones, dones, [](const PlainRtBench::Done& d) {
    return format("cycle {} slot {} round {}", d.cycle, d.slot, d.round);
  });
}

/// Any configuration, from roomy to starved.
BenchOptions random_configuration(std::mt19937& random) {
  const auto one_of = [&](std::initializer_list<unsigned> values) {
    return *(values.begin() + std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random));
  };
  BenchOptions options;
  options.memory_latency = one_of({2, 3, 20, 117});
  options.any_hit_cycles = one_of({1, 10, 60});
  modules::RtUnitConfig& rt = options.rt;
  rt.warp_buffer.entries = one_of({1, 2, 4, 8});
  const char* policies[] = {"oldest_first", "round_robin", "greedy_then_oldest"};
  rt.scheduler.policy = policies[one_of({0, 1, 2})];
  rt.memory.queue = one_of({32, 40, 64});
  rt.memory.merge_in_flight = one_of({0, 1}) != 0;
  rt.memory.traffic.instance_leaf_bytes = one_of({64, 128});
  rt.memory.traffic.blas_header_read = one_of({0, 1}) != 0;
  rt.memory.traffic.leaf_descriptor_read = one_of({0, 1}) != 0;
  for (auto* unit : {&rt.ray_box, &rt.ray_triangle, &rt.ray_sphere, &rt.ray_transform}) {
    *unit = {one_of({1, 2, 4, 32}), one_of({1, 4, 13, 37}), one_of({1, 2, 5})};
  }
  rt.box_op_per_child = one_of({0, 1}) != 0;
  rt.any_hit.timeout = one_of({1, 5, 64, 1000});
  rt.checkpoint.lanes = one_of({1, 2, 4, 32});
  rt.checkpoint.write_queue = one_of({2, 3, 16});
  rt.checkpoint.write_combine = one_of({0, 1}) != 0;
  rt.checkpoint.read_buffer = one_of({0, 1}) != 0;
  rt.checkpoint.entry_bytes = one_of({8, 16, 20, 28});
  rt.sibling_prefetch = one_of({0, 1, 1}) != 0;
  rt.prefetcher = {one_of({1, 4}), one_of({2, 32}), one_of({0, 1}) != 0};
  rt.warp_buffer.spill = one_of({0, 1, 1}) != 0;
  rt.warp_buffer.stack_entries = one_of({2, 3, 4, 8});
  return options;
}

class RtUnitPlainDirected : public modules::SystemCTest {};

class RtUnitPlain : public modules::SystemCTest, public ::testing::WithParamInterface<unsigned> {};

// 20 x 50 = 1,000 random traces, each with a configuration of its own.
TEST_P(RtUnitPlain, AgreesToTheCycle) {
  for (unsigned i = 0; i < 50 && !HasFailure(); ++i) {
    const unsigned seed = GetParam() * 50 + i;
    std::mt19937 random(seed);
    const auto pick = [&](unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(random); };
    RandomOptions trace{
        .seed = seed, .groups = 1 + pick(5), .warp_size = pick(3) == 0 ? 32u : 8u, .bvh_width = 2 + pick(6)};
    trace.depth = trace.warp_size * trace.bvh_width > 64 ? 2 : 3;  // wide trees of full warps take long
    trace.k = 1 + pick(7);
    trace.checkpoint = pick(3) != 0;
    trace.capacity = pick(3) == 0 ? 6 : 1000;
    trace.checkpoint_order = pick(2) == 0 ? traces::CheckpointOrder::lifo : traces::CheckpointOrder::fifo;
    trace.two_level = pick(1) != 0;
    if (trace.two_level && seed % 3 == 0) {
      trace.objects = 1 + seed % 4;
      trace.depth = 2;
    }
    trace.blas_root_is_leaf = trace.two_level && pick(4) == 0;
    if (seed % 4 == 3) trace.layout = traces::NodeLayout::compact;
    if (seed % 8 == 2) trace.layout = traces::NodeLayout::obb;
    if (seed % 8 == 6) trace.layout = traces::NodeLayout::compressed;
    BenchOptions configuration = random_configuration(random);
    trace.child_order = enum_names(traces::ChildOrder{})[pick(2)].value;
    trace.pop_test = pick(1) == 0 ? traces::PopTest::off : traces::PopTest::on;
    if (trace.pop_test == traces::PopTest::off) {  // four entries of its stack fill a sector
      unsigned& stack = configuration.rt.warp_buffer.stack_entries;
      stack = std::max(stack, 4u);
    }
    SCOPED_TRACE(traces::testing::describe(trace));
    const auto made = random_trace(trace);
    expect_agreement(made.header, made.groups, configuration);
  }
}
INSTANTIATE_TEST_SUITE_P(Traces, RtUnitPlain, ::testing::Range(0u, 20u));

// Trees do not lead there: a leaf whose node is visited in a round has no BLAS node in that round's source buffer.
TEST_F(RtUnitPlainDirected, AReplayedBlasNodeAsksForItsLeafAsAnyVisitDoes) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::instance, NodeKind::instance})};
  group.rays.resize(1);
  constexpr std::uint32_t kBlasLeaf = (1 << 19) / traces::kNodeUnit + 1;
  group.nodes.push_back(node_definition(2, 1, {NodeKind::internal}));
  add_round(group.rays[0], {internal_event(1, 0b1, 0b1), cull_event(1, 1)});
  add_round(group.rays[0],
            {take_event(1), internal_event(0, 0b11), cull_event(12, 0), cull_event(10, 0), take_event(kBlasLeaf),
             instance_event(10, 1), leaf_event(kBlasLeaf, LeafOutcome::miss)},
            true);
  expect_agreement(small_header("tlas-tri20", 64), {group}, {});
}

}  // namespace
}  // namespace grtx::sim
