// SPDX-License-Identifier: Apache-2.0
// The whole model a second time: plain C++, every unit ticked in every cycle, from the pages of docs/model alone.
// docs/model/gpu.md says how the units are joined.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/clocks.h"
#include "rtl_tlm/plain/crossbar.h"
#include "rtl_tlm/plain/dram_channel.h"
#include "rtl_tlm/plain/l1_cache.h"
#include "rtl_tlm/plain/l2_slice.h"
#include "rtl_tlm/plain/rt_unit.h"
#include "rtl_tlm/plain/simt_core.h"
#include "rtl_tlm/plain/work_distributor.h"

namespace grtx::sim::plain {

/// Warps that an SM holds: as many as it has slots for, and registers.
inline unsigned warp_slots(const GpuConfig& config) {
  const modules::RegisterFile& file = config.simt.register_file;
  const unsigned of_a_thread = file.registers_per_thread + file.payload_registers;
  if (file.registers_per_thread == 0) return config.resident_warps;
  return std::min(config.resident_warps, static_cast<unsigned>(file.registers / 32 / of_a_thread));
}

/// SIMT core, RT units and L1 with what lies between them.
class Sm {
 public:
  Sm(const GpuConfig& config, const traces::Header& header, const AddressMap& map, unsigned number)
      : launch(config.sm_links.message_latency, warp_slots(config)),
        ended(config.sm_links.message_latency, warp_slots(config)),
        to_memory(config.links.latency, config.links.capacity),
        from_memory(config.links.latency, config.links.capacity) {
    // Clients of the L1 in the order of docs/model/l1_cache.md: those of the first RT unit stand around the SIMT core.
    std::vector<L1Cache::Port> clients;
    const auto port = [&](bool exists, unsigned width = 1) -> MemoryPort* {
      if (!exists) return nullptr;
      using Link = Channel<Access>;
      const std::size_t places = std::size_t{config.sm_links.l1_capacity} * width;
      ports_.push_back({Link(config.sm_links.l1_latency, places), Link(config.sm_links.l1_latency, places)});
      clients.push_back({&ports_.back(), width});
      return &ports_.back();
    };
    std::vector<RtMessages*> messages;
    std::vector<RtUnit::Memory> memories;
    MemoryPort* simt_port = nullptr;
    for (unsigned u = 0; u < config.rt_units; ++u) {
      messages_.emplace_back(config.sm_links.message_latency, warp_slots(config));
      messages.push_back(&messages_.back());
      RtUnit::Memory memory{};
      memory.node = port(!config.rt.memory.by_shader, config.rt.memory.sectors_per_cycle);
      if (u == 0) simt_port = port(true, config.simt.sectors_per_cycle);
      memory.checkpoint = port(header.checkpoint);
      memory.prefetch = port(config.rt.sibling_prefetch && config.rt.traversal == modules::TraversalWay::lane);
      memory.stack = port(config.rt.warp_buffer.spill);
      memories.push_back(memory);
    }
    modules::SimtCoreConfig simt = config.simt;
    simt.heap = config.rt.any_hit_unit;
    simt.heap.alpha = config.rt.gaussian_unit &&
                      (header.accel == traces::AccelKind::ellipsoid || header.accel == traces::AccelKind::tlas_sphere);
    simt_ =
        std::make_unique<SimtCore>(simt, header, map, number, warp_slots(config), launch, ended, messages, *simt_port);
    for (unsigned u = 0; u < config.rt_units; ++u) {
      rt_.push_back(std::make_unique<RtUnit>(config.rt, header, map, number, *messages[u], memories[u]));
    }
    l1_ = std::make_unique<L1Cache>(config.l1, number, config.sm_links.l1_latency, clients, to_memory, from_memory);
    l1_first_ = config.rt.memory.l1_hit_latency < 10000;
    if (l1_first_) rt_[0]->l1 = [this](Cycle now, const Access& access) { return l1_->read_at_once(now, access); };
  }

  void tick(Cycle now) {
    simt_->tick(now);
    if (l1_first_) l1_->tick(now);
    for (auto& rt : rt_) rt->tick(now);
    if (!l1_first_) l1_->tick(now);
  }
  bool idle() const {
    return simt_->idle() && l1_->idle() &&
           std::all_of(rt_.begin(), rt_.end(), [](const auto& rt) { return rt->idle(); });
  }
  void stop_counting() {
    for (auto& rt : rt_) rt->stop_counting();
  }
  void report(Statistics& s, const std::string& name) const {
    simt_->report(s);
    l1_->report(s);
    for (std::size_t u = 0; u < rt_.size(); ++u) {
      rt_[u]->report(s);
      s.add(name + ".rt" + (u == 0 ? "" : std::to_string(u)) + ".selections", rt_[u]->selections());
    }
  }

  Channel<Launch> launch;
  Channel<WarpEnded> ended;
  Channel<Access> to_memory, from_memory;

 private:
  std::deque<MemoryPort> ports_;
  std::deque<RtMessages> messages_;
  std::unique_ptr<SimtCore> simt_;
  std::vector<std::unique_ptr<RtUnit>> rt_;
  std::unique_ptr<L1Cache> l1_;
  bool l1_first_ = false;  ///< the RT unit asks it in the cycle of the request
};

inline constexpr Cycle kDrainStep = 256;

/// The statistics of a run of these groups. most_evictions: of a ray, from the totals of the trace.
inline Statistics run(const GpuConfig& machine, const traces::Header& header,
                      const std::vector<traces::RayGroup>& groups, std::uint64_t most_evictions) {
  const GpuConfig config = machine.at_bandwidth();
  const Clock core(config.core_mhz), memory(config.memory_mhz);
  const AddressMap map(header, config.sms, warp_slots(config), most_evictions,
                       config.rt.warp_buffer.spill ? 256 / stack_entries_of_a_sector(header) : 0,
                       config.rt.checkpoint.entry_bytes, config.simt.k_buffer_layout == modules::RayArrayLayout::by_ray,
                       config.simt.eviction_layout == modules::RayArrayLayout::by_lane);
  const SliceMap slices(config.interleave);

  std::deque<Sm> sms;
  std::vector<WorkDistributor::Port> ports;
  std::vector<Channel<Access>*> from_sms, to_sms;
  for (unsigned i = 0; i < config.sms; ++i) {
    sms.emplace_back(config, header, map, i);
    ports.push_back({&sms.back().launch, &sms.back().ended});
    from_sms.push_back(&sms.back().to_memory);
    to_sms.push_back(&sms.back().from_memory);
  }
  WorkDistributor distributor(groups, ports, warp_slots(config));

  std::deque<Channel<Access>> slice_requests, slice_responses;
  std::deque<DramSocket> sockets(config.interleave.slices);
  std::deque<L2Slice> l2;
  std::deque<DramChannel> dram;
  std::vector<Channel<Access>*> to_slices, from_slices;
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    to_slices.push_back(&slice_requests.emplace_back(config.links.latency, config.links.capacity));
    from_slices.push_back(&slice_responses.emplace_back(config.links.latency, config.links.capacity));
    l2.emplace_back(config.l2, config.l2_bytes / config.interleave.slices, i, slices, core, slice_requests.back(),
                    slice_responses.back(), sockets[i]);
  }
  for (unsigned i = 0; i < slices.channels(); ++i) dram.emplace_back(config.dram, slices, memory, core, i, sockets);
  const CrossbarNetwork::Config noc{config.crossbar.latency, config.links.latency, config.crossbar.output_buffer};
  CrossbarNetwork requests(noc, from_sms, to_slices, [&](const Access& a) { return slices.slice(a.address); });
  CrossbarNetwork replies(noc, from_slices, to_sms, [](const Access& a) { return a.sm; });

  const auto empty = [](const auto& channels) {
    return std::all_of(channels.begin(), channels.end(), [](const auto* c) { return c->empty(); });
  };
  const auto idle = [](const auto& units) {
    return std::all_of(units.begin(), units.end(), [](const auto& unit) { return unit.idle(); });
  };
  Cycle cycle = 0, clock = 0;
  for (;;) {
    if (memory.edge(clock) < core.edge(cycle)) {
      for (DramChannel& channel : dram) channel.tick(clock);
      ++clock;
      continue;
    }
    const bool running = !distributor.done();
    distributor.tick(cycle);
    if (running && distributor.done()) {
      for (Sm& sm : sms) sm.stop_counting();
    }
    for (Sm& sm : sms) sm.tick(cycle);
    requests.tick(cycle);
    for (L2Slice& slice : l2) slice.tick(cycle);
    replies.tick(cycle);
    ++cycle;
    const bool quiet = distributor.done() && idle(sms) && idle(l2) && idle(dram) && requests.idle() && replies.idle() &&
                       empty(from_sms) && empty(to_sms) && empty(to_slices) && empty(from_slices);
    if (quiet) break;
    if (cycle > 100'000'000) throw std::runtime_error("the plain model does not come to an end");
  }

  Statistics s;
  const Cycle cycles = distributor.end_cycle();
  s.add("gpu.cycles", cycles);
  s.values["gpu.time_us"] = static_cast<double>(core.edge(cycles)) * 1e-9;
  distributor.report(s);
  for (std::size_t i = 0; i < sms.size(); ++i) {
    const std::string name = "gpu.sm" + std::to_string(i);
    s.add(name + ".warps", distributor.warps(i));
    sms[i].report(s, name);
  }
  requests.report(s, "gpu.crossbar.request");
  replies.report(s, "gpu.crossbar.reply");
  for (const L2Slice& slice : l2) slice.report(s);
  for (std::size_t i = 0; i < dram.size(); ++i) {
    dram[i].report(s);
    s.add("gpu.dram.channel" + std::to_string(i) + ".bytes", dram[i].bytes());
  }
  RtUnit::finish(s, cycles * config.sms * config.rt_units);
  CacheCounts::finish(s, "gpu.l1");
  s.finish_mean("gpu.l1.miss_latency");
  L2Slice::finish(s);
  s.finish_mean("gpu.dram.access_latency");
  // The drain is looked at every kDrainStep cycles; the time that bandwidth is measured over ends with it.
  const Cycle drain = (cycle - 1 - cycles + kDrainStep - 1) / kDrainStep * kDrainStep;
  const double clocks = static_cast<double>(core.edge(cycles + drain) / memory.period);
  const auto& channel = config.dram.channel;
  const double peak = clocks * channel.burst_bytes / channel.timing.ccd * static_cast<double>(dram.size());
  s.values["gpu.dram.bandwidth_utilisation"] = Statistics::ratio(s["gpu.dram.bytes"], peak);
  return s;
}

}  // namespace grtx::sim::plain
