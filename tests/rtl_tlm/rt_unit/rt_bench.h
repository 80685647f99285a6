// SPDX-License-Identifier: Apache-2.0
// Bench for the RT unit: a SIMT core that answers any-hit batches after a fixed time and calls the next round, and a
// memory of fixed latency behind each of the four L1 clients. Also a builder of small ray groups.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "modules/systemc_fixture.h"

namespace grtx::sim::test {

using modules::Link;
using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;
using traces::NodeKind;

inline Event internal_event(std::uint32_t definition, unsigned pushed, unsigned checkpoints = 0) {
  return {definition, static_cast<std::uint8_t>(pushed), static_cast<std::uint8_t>(checkpoints),
          Event::pack(EventKind::visit_internal)};
}
inline Event instance_event(std::uint32_t node, unsigned detail = 0) {
  return {node, static_cast<std::uint8_t>(detail), 0, Event::pack(EventKind::visit_instance)};
}
inline Event leaf_event(std::uint32_t node, LeafOutcome outcome, unsigned checkpoints = 0, unsigned shifts = 0) {
  return {node, static_cast<std::uint8_t>(outcome), static_cast<std::uint8_t>(checkpoints),
          Event::pack(EventKind::visit_leaf, shifts)};
}
inline Event cull_event(std::uint32_t node, unsigned checkpoints) {
  return {node, 0, static_cast<std::uint8_t>(checkpoints), Event::pack(EventKind::cull)};
}
inline Event take_event(std::uint32_t node) { return {node, 0, 0, Event::pack(EventKind::replay_take)}; }
inline Event forward_event(std::uint32_t node, unsigned checkpoints) {
  return {node, 0, static_cast<std::uint8_t>(checkpoints), Event::pack(EventKind::replay_forward)};
}

/// Appends a round with these events to the ray.
inline void add_round(traces::Ray& ray, const std::vector<Event>& events, bool replay = false) {
  traces::Round round;
  round.event_count = static_cast<std::uint32_t>(events.size());
  round.replay = replay;
  ray.rounds.push_back(round);
  ray.events.insert(ray.events.end(), events.begin(), events.end());
}

inline traces::NodeDefinition node_definition(std::uint32_t address, std::uint32_t child_base,
                                              const std::vector<NodeKind>& kinds) {
  traces::NodeDefinition node{
      .address = address, .child_base = child_base, .child_count = static_cast<std::uint8_t>(kinds.size())};
  for (std::size_t i = 0; i < kinds.size(); ++i) node.child_kinds[i] = kinds[i];
  return node;
}

/// Header of a small trace; 1 MiB of nodes, BLAS (if any) in the upper half.
inline traces::Header small_header(const std::string& accel = "tri20", std::uint64_t checkpoint_capacity = 0) {
  traces::Header header;
  header.accel = *from_name<traces::AccelKind>(accel);
  header.width = header.height = 8;
  header.node_image_bytes = 1 << 20;
  header.root = 64;
  header.two_level = accel.starts_with("tlas");
  if (header.two_level) {
    header.blas_base = 1 << 19;
    header.blas_root = header.blas_base + 64;
  }
  header.gaussians = 16;
  header.checkpoint = checkpoint_capacity > 0;
  header.checkpoint_capacity = checkpoint_capacity;
  return header;
}

struct BenchOptions {
  modules::RtUnitConfig rt;
  unsigned memory_latency = 20;  ///< cycles from a request's issue to the response being visible, >= 2
  unsigned any_hit_cycles = 10;  ///< from a batch being visible to AnyHitDone being sent
  std::size_t resident_warps = 16;
  bool idle_skip = true;
  unsigned construction_order = 0;         ///< 0: SIMT, memory, RT unit; 1: RT unit first; 2: RT unit between
  modules::RtUnitParts parts;              ///< who makes the unit's parts
  modules::read_at_once_if* l1 = nullptr;  ///< for rt.memory.l1_hit_latency
};

class RtBench {
 public:
  struct Done {
    std::uint16_t slot;
    std::uint32_t round;
    Cycle cycle;  ///< in which the RT unit retired the warp
  };
  struct Batch {
    modules::AnyHitBatch batch;
    Cycle cycle;  ///< in which the RT unit sent it
  };
  struct Request {
    modules::MemoryRequest request;
    Cycle cycle;  ///< in which the RT unit sent it
  };

  RtBench(const traces::Header& header, BenchOptions options)
      : options_(std::move(options)),
        map_(header, {1, static_cast<unsigned>(options_.resident_warps), 0, options_.rt.warp_buffer.spill ? 128u : 0u,
                      options_.rt.checkpoint.entry_bytes}),
        clock_("clock", 1000.0, options_.idle_skip) {
    const auto make_rt = [&] {
      rt_ = std::make_unique<modules::RtUnit>("rt", options_.rt, header, map_, clock_, 0u, options_.parts);
    };
    const auto make_simt = [&] {
      simt_ = std::make_unique<modules::TickProcess>("simt", clock_, [this](Cycle now) { simt(now); });
    };
    const auto make_memory = [&] {
      memory_ = std::make_unique<modules::TickProcess>("memory", clock_, [this](Cycle now) { memory(now); });
    };
    if (options_.construction_order == 1) make_rt();
    make_simt();
    if (options_.construction_order == 2) make_rt();
    make_memory();
    if (options_.construction_order == 0) make_rt();
    for (unsigned c = 0; c < 4; ++c) {
      const std::string number = std::to_string(c);
      requests_.push_back(std::make_unique<Link<modules::MemoryRequest>>("requests" + number, 1, 4));
      responses_.push_back(
          std::make_unique<Link<modules::MemoryResponse>>("responses" + number, options_.memory_latency - 1, 4096));
    }
    simt_->watch(dones_);
    simt_->watch(batches_);
    for (const auto& link : requests_) memory_->watch(*link);
    rt_->trace_call(calls_);
    rt_->trace_done(dones_);
    rt_->any_hit_batch(batches_);
    rt_->any_hit_done(shader_dones_);
    rt_->node_request(*requests_[0]);
    rt_->node_response(*responses_[0]);
    if (options_.l1 != nullptr) rt_->node_reads(*options_.l1);
    if (rt_->has_checkpoint()) {
      rt_->checkpoint_request(*requests_[1]);
      rt_->checkpoint_response(*responses_[1]);
    }
    if (rt_->has_prefetcher()) {
      rt_->prefetch_request(*requests_[2]);
      rt_->prefetch_response(*responses_[2]);
    }
    if (rt_->has_stack()) {
      rt_->stack_request(*requests_[3]);
      rt_->stack_response(*responses_[3]);
    }
  }

  /// Queues the first round of a group in a slot; later rounds follow when the previous one is done.
  void launch(const traces::RayGroup& group, std::uint16_t slot, std::uint32_t round = 0) {
    to_call_.push_back(call(group, slot, round));
    groups_.resize(std::max<std::size_t>(groups_.size(), slot + std::size_t{1}));
    groups_[slot] = &group;
  }
  /// Runs until all calls are done and the RT unit is idle; the first call is sent in cycle 0.
  void run(Cycle limit = 1'000'000) {
    clock_.request(0);
    const auto quiet = [&] { return to_call_.empty() && pending_ == 0 && rt_->idle(); };
    // In steps, because a clock without idle skip never runs dry; what happens after the end changes no count.
    constexpr Cycle kStep = 256;
    for (Cycle c = 0; c < limit && sc_core::sc_pending_activity(); c += kStep) {
      sc_core::sc_start(sc_core::sc_time::from_value(clock_.period_fs() * kStep));
      if (quiet()) break;
    }
    if (!rt_->idle() || pending_ != 0) {
      std::ostringstream state;
      rt_->dump_state(state);
      ADD_FAILURE() << "the RT unit is not idle at the end\n" << state.str();
    }
  }
  void run(const traces::RayGroup& group, std::uint16_t slot = 0) {
    launch(group, slot);
    run();
  }
  /// Runs without looking at the state afterwards; errors of the modules come out as exceptions.
  void run_expecting_error() {
    clock_.request(0);
    sc_core::sc_start();
  }
  /// Counters up to the cycle in which the last warp retired.
  modules::RtUnitCounters counters() {
    rt_->settle(dones.empty() ? 0 : dones.back().cycle + 1);
    return rt_->counters();
  }
  /// Cycles that counters() covers.
  Cycle end_of_counts() const { return std::max(rt_->accounted(), dones.empty() ? 0 : dones.back().cycle + 1); }
  std::string statistics() {
    rt_->settle(dones.empty() ? 0 : dones.back().cycle + 1);
    modules::StatisticList list;
    rt_->statistics(list, "gpu.rt");
    std::ostringstream out;
    for (const auto& s : list.items()) {
      std::visit([&](auto v) { out << s.name << ' ' << v << '\n'; }, s.value);
    }
    return out.str();
  }
  modules::RtUnit& rt() { return *rt_; }
  const modules::MemoryMap& map() const { return map_; }

  std::vector<Done> dones;
  std::vector<Batch> batches;
  std::vector<Request> requests[4];  ///< by client: node, checkpoint, prefetch, stack

 private:
  static modules::TraceCall call(const traces::RayGroup& group, std::uint16_t slot, std::uint32_t round) {
    modules::TraceCall c{&group, round, slot, 0};
    for (unsigned i = 0; i < group.rays.size(); ++i) {
      if (round < group.rays[i].rounds.size()) c.lanes |= LaneMask{1} << i;
    }
    return c;
  }

  void simt(Cycle now) {
    while (const auto* done = dones_.front(now)) {
      dones.push_back({done->slot, done->round, now - 1});
      --pending_;
      const auto next = call(*groups_[done->slot], done->slot, done->round + 1);
      dones_.pop(now);
      if (next.lanes != 0) to_call_.push_back(next);
    }
    while (const auto* batch = batches_.front(now)) {
      batches.push_back({*batch, now - 1});
      shaders_.emplace_back(now + options_.any_hit_cycles, modules::AnyHitDone{batch->slot, batch->lanes});
      batches_.pop(now);
    }
    if (!shaders_.empty() && shaders_.front().first <= now && shader_dones_.can_push(now)) {
      shader_dones_.push(now, shaders_.front().second);
      shaders_.pop_front();
      clock_.request(now + 1);
    }
    if (!shaders_.empty()) clock_.request(std::max(now + 1, shaders_.front().first));
    if (!to_call_.empty() && calls_.can_push(now)) {
      calls_.push(now, to_call_.front());
      to_call_.pop_front();
      ++pending_;
      clock_.request(now + 1);
    }
    if (!to_call_.empty()) clock_.request(now + 1);
  }

  void memory(Cycle now) {
    for (unsigned c = 0; c < 4; ++c) {
      while (const auto* request = requests_[c]->front(now)) {
        requests[c].push_back({*request, now - 1});
        modules::MemoryResponse response{.address = request->address,
                                         .tag = request->tag,
                                         .region = request->region,
                                         .write = request->write,
                                         .prefetch = request->prefetch};
        responses_[c]->push(now, response);
        requests_[c]->pop(now);
        clock_.request(now + responses_[c]->latency());
      }
    }
  }

  modules::FreshContext context_;
  BenchOptions options_;
  modules::MemoryMap map_;
  modules::ClockDomain clock_;
  Link<modules::TraceCall> calls_{"calls", 1, 2};
  Link<modules::TraceDone> dones_{"dones", 1, 2};
  Link<modules::AnyHitBatch> batches_{"batches", 1, 2};
  Link<modules::AnyHitDone> shader_dones_{"shader_dones", 1, 2};
  std::vector<std::unique_ptr<Link<modules::MemoryRequest>>> requests_;
  std::vector<std::unique_ptr<Link<modules::MemoryResponse>>> responses_;
  std::unique_ptr<modules::TickProcess> simt_;
  std::unique_ptr<modules::TickProcess> memory_;
  std::unique_ptr<modules::RtUnit> rt_;
  std::deque<modules::TraceCall> to_call_;
  std::deque<std::pair<Cycle, modules::AnyHitDone>> shaders_;
  std::vector<const traces::RayGroup*> groups_;
  std::size_t pending_ = 0;
};

}  // namespace grtx::sim::test
