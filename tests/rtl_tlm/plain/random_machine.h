// SPDX-License-Identifier: Apache-2.0
// A random trace's options and a random machine, from roomy to starved, for tests that compare two models.
#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  unsigned upto(unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(engine_); }
  template <typename T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(engine_));
  }
  bool coin() { return upto(1) != 0; }

 private:
  std::mt19937 engine_;
};

inline traces::testing::RandomOptions random_options(Random& random, unsigned seed) {
  traces::testing::RandomOptions trace{.seed = seed,
                                       .groups = 1 + random.upto(11),
                                       .warp_size = random.one_of({4U, 8U, 8U, 32U}),
                                       .bvh_width = 2 + random.upto(6)};
  trace.depth = trace.warp_size * trace.bvh_width > 64 ? 2 : 3;  // wide trees of full warps take long
  trace.k = 1 + random.upto(7);
  trace.two_level = random.coin();
  if (trace.two_level && seed % 3 == 0) {
    trace.objects = 1 + seed % 4;
    trace.depth = 2;
  }
  trace.blas_root_is_leaf = trace.two_level && random.upto(4) == 0;
  trace.root_is_leaf = random.upto(30) == 0;
  trace.child_order = random.coin() ? traces::ChildOrder::near_first : traces::ChildOrder::slot;
  trace.tracing = random.one_of({traces::Tracing::multi, traces::Tracing::multi, traces::Tracing::multi,
                                 traces::Tracing::single, traces::Tracing::closest});
  trace.checkpoint = trace.tracing == traces::Tracing::multi && random.upto(2) != 0;
  if (trace.tracing == traces::Tracing::closest) trace.k = 1;
  if (trace.tracing == traces::Tracing::single) trace.k = random.one_of({1U, 3U, 8U, 100U});
  trace.capacity = trace.checkpoint ? random.one_of({6U, 1000U, 1000U}) : 0;
  trace.checkpoint_order =
      random.one_of({traces::CheckpointOrder::fifo, traces::CheckpointOrder::lifo, traces::CheckpointOrder::nearest});
  if (seed % 5 == 4) trace.child_order = traces::ChildOrder::vulkan_sim;
  if (seed / 2 % 2 == 1) trace.pop_test = traces::PopTest::off;
  using traces::NodeLayout;
  if (seed / 4 % 2 == 1) {
    trace.layout = random.one_of({NodeLayout::compact, NodeLayout::compressed, NodeLayout::quantised});
  }
  if (trace.objects != 0 && trace.layout == NodeLayout::quantised) trace.layout = NodeLayout::compressed;
  if (trace.layout == NodeLayout::quantised) trace.bvh_width = std::min(trace.bvh_width, traces::kQuantisedWidth);
  if (trace.tracing == traces::Tracing::single && seed % 2 == 0) trace.tracing = traces::Tracing::list;
  Random bins = random;  // a copy, so that all that is drawn from the original stays what it is for a seed
  if (trace.checkpoint && bins.coin()) {
    trace.bins = bins.one_of({2U, 4U, 8U, 32U});
    trace.capacity = bins.one_of({3U, 8U, 1000U});
    trace.checkpoint_order = traces::CheckpointOrder::fifo;
  }
  Random delayed = bins;  // likewise
  if (trace.tracing == traces::Tracing::multi && !trace.checkpoint && delayed.coin()) {
    trace.any_hit = traces::AnyHit::delayed;
  }
  Random widths = delayed;  // likewise
  trace.wide = trace.layout == NodeLayout::quantised && widths.upto(2) != 0;
  Random colours = widths;  // likewise
  if (trace.objects == 0 && colours.upto(2) == 0) trace.colour = traces::ColourPer::frame;
  return trace;
}

/// Ellipsoids or spheres in place of triangles, or boxes.
inline void make_procedural(traces::testing::RandomTrace& trace, bool boxes = false) {
  using traces::AccelKind;
  trace.header.accel = trace.header.two_level ? (boxes ? AccelKind::tlas_box : AccelKind::tlas_sphere)
                                              : (boxes ? AccelKind::box : AccelKind::ellipsoid);
  for (traces::RayGroup& group : trace.groups) {
    for (traces::NodeDefinition& node : group.nodes) {
      for (traces::NodeKind& kind : node.child_kinds) {
        if (kind == traces::NodeKind::triangle) kind = traces::NodeKind::procedural;
      }
    }
  }
}

/// A random trace as a file whose launches are ordered as a tracer orders them.
inline void write_random(const std::string& path, traces::testing::RandomOptions options, bool procedural) {
  options.procedural = procedural && options.layout == traces::NodeLayout::quantised;  // their size differs
  auto trace = traces::testing::random_trace(options);
  std::stable_sort(trace.groups.begin(), trace.groups.end(),
                   [](const auto& a, const auto& b) { return a.kind < b.kind; });
  for (std::uint32_t g = 0; g < trace.groups.size(); ++g) trace.groups[g].index = g;
  if (procedural) make_procedural(trace);
  traces::testing::write_trace(path, trace.header, trace.groups);
}

/// Any machine, from roomy to starved.
inline GpuConfig random_machine(Random& random) {
  GpuConfig c;
  c.rt.checkpoint.traffic = modules::TrafficCharging::charged;  // the plain machine has no other
  c.sms = 1 + random.upto(3);
  c.resident_warps = random.one_of({1U, 2U, 4U, 8U, 32U, 40U});
  c.rt_units = std::min(c.resident_warps, random.one_of({1U, 1U, 2U, 3U}));
  c.core_mhz = random.one_of({1365.0, 1365.0, 1000.0, 2100.0, 333.0});
  c.memory_mhz = random.one_of({3500.0, 3500.0, 1000.0, 500.0, 7001.0});

  modules::RtUnitConfig& rt = c.rt;
  rt.warp_buffer.entries = random.one_of({1U, 2U, 4U, 8U});
  rt.warp_buffer.spill = random.upto(2) == 0;
  rt.warp_buffer.stack_entries = random.one_of({2U, 3U, 4U, 8U});
  rt.scheduler.policy = random.one_of({"oldest_first", "round_robin", "greedy_then_oldest"});
  rt.memory.queue = random.one_of({32U, 40U, 64U});
  rt.memory.merge_in_flight = random.coin();
  rt.memory.sectors_per_cycle = random.one_of({1U, 1U, 2U, 4U});
  rt.memory.by_shader = random.upto(5) == 0;
  rt.memory.traffic.instance_leaf_bytes = random.one_of({64U, 128U});
  rt.memory.traffic.blas_header_read = random.coin();
  rt.memory.traffic.leaf_descriptor_read = random.coin();
  for (auto* unit : {&rt.ray_box, &rt.ray_triangle, &rt.ray_sphere, &rt.ray_transform}) {
    *unit = {random.one_of({1U, 2U, 4U, 32U}), random.one_of({1U, 4U, 13U, 37U}), random.one_of({1U, 2U, 5U})};
  }
  rt.box_op_per_child = random.coin();
  rt.any_hit.timeout = random.one_of({0U, 1U, 5U, 64U, 1000U});
  rt.checkpoint.lanes = random.one_of({1U, 2U, 4U, 32U});
  rt.checkpoint.write_queue = random.one_of({2U, 3U, 16U});
  rt.checkpoint.write_combine = random.coin();
  rt.checkpoint.read_buffer = random.coin();
  rt.sibling_prefetch = random.upto(2) != 0;
  rt.prefetcher = {random.one_of({1U, 4U}), random.one_of({1U, 2U, 32U})};

  c.simt.schedulers = random.one_of({1U, 2U, 3U, 4U});
  c.simt.instruction_latency = random.one_of({0U, 1U, 4U, 20U});
  c.simt.sectors_per_cycle = random.one_of({1U, 1U, 2U, 4U});
  using modules::RayArrayLayout;
  c.simt.k_buffer_layout = random.upto(2) == 0 ? RayArrayLayout::by_ray : RayArrayLayout::by_lane;
  c.simt.eviction_layout = random.upto(2) == 0 ? RayArrayLayout::by_lane : RayArrayLayout::by_ray;
  c.simt.costs.dependent_loads = random.upto(3) != 0;
  c.sm_links.message_latency = random.one_of({1U, 1U, 2U, 7U});
  modules::ShaderCosts& costs = c.simt.costs;
  for (unsigned* cost :
       {&costs.raygen_prologue, &costs.trace_call, &costs.evict_move_fixed, &costs.evict_move_per_entry,
        &costs.any_hit_fixed, &costs.any_hit_per_shift, &costs.sort_per_entry, &costs.blend_fixed,
        &costs.blend_per_entry, &costs.sh_per_coefficient, &costs.epilogue, &costs.node_fetch}) {
    if (random.upto(3) == 0) *cost = random.one_of({0U, 1U, 7U, 50U});
  }

  auto& l1 = c.l1;
  l1.geometry.line_bytes = random.one_of({32U, 64U, 128U, 128U, 256U});
  l1.geometry.ways = random.one_of({1U, 2U, 4U, 16U});
  l1.geometry.bytes = std::uint64_t{l1.geometry.line_bytes} * l1.geometry.ways * random.one_of({1U, 3U, 8U, 32U});
  l1.geometry.replacement = random.one_of({"lru", "lru", "fifo", "random"});
  c.sm_links.l1_latency = random.one_of({1U, 1U, 2U, 3U});
  c.sm_links.l1_capacity = random.one_of({1U, 2U, 4U, 4U});
  l1.latency = c.sm_links.l1_latency + random.one_of({0U, 1U, 4U, 19U});
  l1.tag_latency = random.one_of({1U, 1U, 3U});
  l1.banks = random.one_of({1U, 2U, 3U, 4U});
  l1.mshr_entries = random.one_of({1U, 4U, 16U, 256U});
  l1.mshr_merges = random.one_of({1U, 2U, 8U});
  l1.miss_queue = random.one_of({1U, 2U, 16U});
  l1.rotating_priority = random.coin();
  l1.private_writes.policy = random.one_of({modules::WritePolicy::write_through, modules::WritePolicy::write_back});
  l1.private_writes.allocate = random.upto(2) == 0;
  l1.perfect = random.upto(15) == 0;

  c.links.latency = random.one_of({1U, 1U, 2U});
  c.links.capacity = random.one_of({1U, 2U, 4U, 4U});
  c.crossbar.latency = c.links.latency + random.one_of({0U, 1U, 3U, 7U});
  c.crossbar.output_buffer = random.one_of({1U, 2U, 32U});

  c.interleave.slices = random.one_of({1U, 2U, 3U, 4U});
  c.interleave.bytes = random.one_of({256U, 256U, 1024U});
  c.interleave.xor_hash = c.interleave.slices != 3 && random.coin();
  auto& l2 = c.l2;
  l2.geometry.line_bytes = random.one_of({32U, 64U, 128U, 128U, 256U});
  l2.geometry.ways = random.one_of({1U, 2U, 4U, 16U});
  l2.geometry.replacement = random.one_of({"lru", "lru", "fifo", "random"});
  c.l2_bytes = std::uint64_t{l2.geometry.line_bytes} * l2.geometry.ways * random.one_of({1U, 3U, 16U, 64U}) *
               c.interleave.slices;
  l2.latency = random.one_of({1U, 5U, 30U, 165U});
  l2.queue = random.one_of({1U, 4U, 64U});
  l2.mshr_entries = random.one_of({1U, 4U, 192U});
  l2.mshr_merges = random.one_of({1U, 2U, 4U});
  l2.reply_queue = random.one_of({4U, 8U, 64U});
  l2.dram_queue = random.one_of({8U, 9U, 64U});
  l2.perfect = random.upto(15) == 0;

  auto& dram = c.dram;
  dram.channel.banks = random.one_of({1U, 2U, 4U, 16U});
  dram.channel.row_bytes = random.one_of({32U, 256U, 2048U});
  dram.channel.burst_bytes = random.one_of({16U, 32U, 32U});
  dram.channel.queue = random.one_of({4U, 5U, 64U});
  dram.channel.age_cap = random.one_of({0U, 30U, 200U, 1024U});
  dram.channel.scheduling = random.one_of({"fr_fcfs", "fr_fcfs", "fcfs", "fr_fcfs_cap"});
  dram.channel.hit_cap = random.one_of({1U, 4U});
  dram.channel.bank_xor = random.upto(2) == 0;
  dram.fixed_latency = random.one_of({0U, 1U, 64U, 256U});
  dram.perfect = random.upto(15) == 0;
  auto& t = dram.channel.timing;
  for (unsigned* clocks : {&t.rrd, &t.rcd, &t.ras, &t.rp, &t.rc, &t.cl, &t.wl, &t.cdlr, &t.wr, &t.rtp, &t.turn}) {
    if (random.upto(3) == 0) *clocks = random.one_of({0U, 1U, 6U, 33U});
  }
  t.ccd = random.one_of({1U, 4U, 4U, 9U});
  Random hits = random;  // a copy, so that all that is drawn from the original stays what it is for a seed
  if (hits.upto(2) == 0) {
    rt.any_hit_unit.enabled = true;
    rt.any_hit_unit.latency = hits.one_of({1U, 2U, 9U});
    rt.any_hit_unit.level_latency = hits.one_of({0U, 2U, 5U});
    rt.any_hit_unit.count = hits.one_of({1U, 3U, 32U});
  }
  rt.gaussian_unit = hits.coin();
  rt.ray_gaussian = {hits.one_of({1U, 2U, 4U, 32U}), hits.one_of({1U, 4U, 27U}), hits.one_of({1U, 2U, 5U})};
  costs.blend_with_alpha = hits.one_of({0U, 1U, 10U});
  Random traffic = hits;  // likewise
  using modules::TrafficCharging;
  if (traffic.upto(3) == 0) rt.checkpoint.traffic = TrafficCharging::uncharged;
  if (traffic.upto(3) == 0) c.simt.costs.eviction_traffic = TrafficCharging::uncharged;
  Random channels = traffic;    // likewise
  if (channels.upto(2) == 0) {  // slices share them
    c.interleave.channels = c.interleave.slices;
    const unsigned shared = c.interleave.xor_hash ? channels.one_of({2U, 4U}) : channels.one_of({2U, 2U, 3U});
    c.interleave.slices *= shared;
    c.l2_bytes *= shared;
  }
  Random buffer = channels;  // likewise
  l1.write_back_buffer = buffer.one_of({1U, 2U, 16U});
  rt.checkpoint.entry_bytes = buffer.one_of({8U, 16U, 20U, 20U, 28U});
  rt.prefetcher.replayed = buffer.coin();
  if (buffer.coin()) {  // what only some parts have
    auto& more = dram.channel;
    more.bank_groups = more.banks == 1 ? 1 : buffer.one_of({1U, 2U, std::min(more.banks, 4U)});
    more.group_bytes = std::max(32U, std::min(more.row_bytes, buffer.one_of({32U, 64U, 256U})));
    t.ccd_l = buffer.one_of({0U, 7U});
    t.rrd_l = buffer.one_of({0U, 23U});
    t.cdlr_l = buffer.one_of({0U, 12U});
    t.rcd_wr = buffer.one_of({0U, 9U});
    t.faw = buffer.one_of({0U, 101U});
    t.rfc = buffer.one_of({0U, 60U});
    t.refi = buffer.one_of({0U, 400U, 3333U});
  }
  Random boxes = buffer;  // likewise
  for (unsigned* cost : {&costs.intersection_fixed, &costs.intersection_transform}) {
    if (boxes.upto(2) == 0) *cost = boxes.one_of({0U, 1U, 60U});
  }
  Random entries = boxes;  // likewise
  rt.checkpoint.open_sectors = entries.one_of({1U, 2U, 3U, 8U});
  Random lists = entries;  // likewise
  costs.list_batch = lists.one_of({1U, 2U, 5U, 32U});
  for (unsigned* cost : {&costs.list_per_entry, &costs.list_exchange}) {
    if (lists.upto(2) == 0) *cost = lists.one_of({0U, 1U, 60U});
  }
  Random registers = lists;  // likewise
  if (registers.upto(3) == 0) {
    c.simt.register_file.registers_per_thread = registers.one_of({40U, 128U, 255U});
    c.simt.register_file.payload_registers = registers.one_of({0U, 32U, 255U});
    c.simt.register_file.registers = registers.one_of({65536U, 49152U});
  }
  Random walks = registers;  // likewise; for machines that walk warps (make_possible())
  rt.warp_stack = {walks.one_of({64U, 10U, 11U, 16U}), walks.one_of({1U, 2U, 3U, 8U, 32U})};
  Random ports = walks;  // likewise
  rt.warp_stack.window = ports.one_of({16U, 0U, 1U, 3U});
  rt.warp_stack.write_ports = ports.one_of({1U, 0U, 1U, 3U});
  rt.warp_stack.tests = ports.one_of({256U, 0U, 1U, 5U, 32U});
  rt.warp_buffer.ray_banks = ports.one_of({0U, 1U, 3U, 4U});
  rt.memory.node_ports = ports.one_of({0U, 1U, 2U});
  rt.leaf_decode_latency = ports.one_of({1U, 0U, 7U});
  Random bandwidth = walks;  // likewise
  if (bandwidth.upto(3) == 0) c.dram_gb_s = c.peak_dram_gb_s() * (bandwidth.coin() ? 0.5 : 1.3);
  Random reads = bandwidth;  // likewise
  if (rt.memory.traffic.leaf_descriptor_read) rt.memory.traffic.descriptor_wait = reads.one_of({0U, 0U, 1U, 4U, 40U});
  if (rt.memory.traffic.blas_header_read) rt.memory.traffic.header_wait = reads.one_of({0U, 0U, 1U, 8U, 40U});
  if (!rt.memory.by_shader && c.rt_units == 1 && reads.coin()) {
    rt.memory.l1_hit_latency = reads.one_of({0U, 0U, 1U, 5U, 50U});
  }
  rt.memory.oldest_warp_first = reads.coin();
  Random calls = reads;  // likewise
  costs.call_fixed = calls.one_of({0U, 0U, 1U, 30U});
  costs.call_per_lane = calls.one_of({0U, 0U, 1U, 20U});
  check_config(c, "a random machine");
  return c;
}

/// Four entries without t fill a sector of a stack. Bins need entries of 8 B. Heaps are for rounds of k hits. Warps
/// walk structures of one level, without checkpoints.
inline void make_possible(GpuConfig& config, const traces::testing::RandomOptions& trace) {
  unsigned& stack = config.rt.warp_buffer.stack_entries;
  if (trace.pop_test == traces::PopTest::off) stack = std::max(stack, 4U);
  if (trace.bins != 0) config.rt.checkpoint.entry_bytes = 8;
  if (trace.tracing != traces::Tracing::multi) config.rt.any_hit_unit.enabled = false;
  if (!trace.two_level && !trace.checkpoint && trace.tracing == traces::Tracing::multi &&
      trace.any_hit == traces::AnyHit::immediate && config.rt.warp_stack.entries != 64) {
    config.rt.traversal = modules::TraversalWay::warp;
    config.rt.warp_buffer.spill = true;
  }
}

/// Two traces of one structure and a machine, all of them random.
struct RandomPair {
  RandomPair(unsigned seed, unsigned family) : random(seed + family) {
    traces::testing::RandomOptions options = random_options(random, seed);
    config = random_machine(random);
    make_possible(config, options);
    const bool procedural = random.upto(3) == 0;
    write_random(first.path(), options, procedural);
    options.seed += 1000;
    options.groups = 1 + random.upto(11);
    write_random(second.path(), options, procedural);
  }
  Random random;
  GpuConfig config;
  traces::testing::TemporaryFile first{"first"}, second{"second"};
};

}  // namespace grtx::sim::test
