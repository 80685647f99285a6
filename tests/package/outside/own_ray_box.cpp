// SPDX-License-Identifier: Apache-2.0
// Replays a trace through one RT unit of the library whose ray-box unit is this program's own:
//   own_ray_box TRACE.grtx
// Around it: a shader core that answers any-hit batches after a fixed time, and a memory of fixed latency.
#include <algorithm>
#include <cstdio>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/rt_unit_if.h"
#include "grtx/traces/reader.h"

namespace {

using grtx::Cycle;
using grtx::LaneMask;
using grtx::modules::kNever;
using grtx::modules::LaneId;
using grtx::modules::Link;

/// One lane at a time, whatever waits: a serial unit, where the library's has pipelines.
class SerialRayBox final : public grtx::modules::IntersectionModule {
 public:
  static constexpr Cycle kCycles = 9;

  explicit SerialRayBox(const sc_core::sc_module_name& name) : IntersectionModule(name) {}

  void enqueue(Cycle now, LaneId id, unsigned) override {
    waiting_.push_back(id);
    if (!busy_) due_ = std::min(due_, now + 1);
  }
  void tick(Cycle now) override {
    if (busy_ && now >= done_at_) {
      busy_ = false;
      ++served;
      client->unit_result(now, lane_);
    }
    if (!busy_ && !waiting_.empty()) {
      lane_ = waiting_.front();
      waiting_.pop_front();
      busy_ = true;
      done_at_ = now + kCycles;
      busy_cycles += kCycles;
    }
    due_ = busy_ ? done_at_ : kNever;
  }
  bool idle() const override { return !busy_ && waiting_.empty(); }
  std::uint64_t progress() const override { return served; }
  grtx::modules::IntersectionCounters counters() const override {
    return {.operations = served, .busy_cycles = busy_cycles};
  }
  grtx::modules::Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override { out << name() << ": " << waiting_.size() << " waiting\n"; }

  std::uint64_t served = 0;
  std::uint64_t busy_cycles = 0;

 private:
  std::deque<LaneId> waiting_;
  LaneId lane_ = 0;
  bool busy_ = false;
  Cycle done_at_ = 0;
};

/// Launches the groups of the trace in the slots of a warp each, round after round, and shades any-hit batches.
class ShaderCore final : public grtx::modules::ClockedModule {
 public:
  static constexpr std::uint16_t kSlots = 8;
  static constexpr Cycle kAnyHitCycles = 10;

  ShaderCore(const sc_core::sc_module_name& name, grtx::modules::ClockDomain& clock, const grtx::traces::Reader& reader)
      : ClockedModule(name, clock), reader_(reader), groups_(kSlots), running_(kSlots) {
    done.wake(&alarm_);
    batches.wake(&alarm_);
    alarm_.request(0);
  }

  Cycle tick(Cycle now) override {
    while (const auto* ended = done.front(now)) {
      running_[ended->slot] = call(ended->slot, ended->round + 1);
      done.pop(now);
    }
    while (const auto* batch = batches.front(now)) {
      shading_.emplace_back(now + kAnyHitCycles, grtx::modules::AnyHitDone{batch->slot, batch->lanes});
      batches.pop(now);
    }
    if (!shading_.empty() && shading_.front().first <= now && shaded.can_push(now)) {
      shaded.push(now, shading_.front().second);
      shading_.pop_front();
    }
    for (std::uint16_t slot = 0; slot < kSlots; ++slot) {
      if (!running_[slot] && next_group_ < reader_.group_count()) {
        reader_.read(next_group_++, groups_[slot]);
        running_[slot] = call(slot, 0);
      }
    }
    if (!to_call_.empty() && calls.can_push(now)) {
      calls.push(now, to_call_.front());
      to_call_.pop_front();
    }
    if (!to_call_.empty() || (next_group_ < reader_.group_count() && !all_running())) return now + 1;
    const Cycle shade = shading_.empty() ? kNever : shading_.front().first;
    return std::min({shade, done.next_visible(), batches.next_visible()});  // what is sent, and not yet visible
  }
  bool finished() const {
    return next_group_ == reader_.group_count() && std::none_of(running_.begin(), running_.end(), std::identity());
  }

  Link<grtx::modules::TraceCall> calls{"calls", 1, 2};
  Link<grtx::modules::TraceDone> done{"done", 1, 2};
  Link<grtx::modules::AnyHitBatch> batches{"batches", 1, 2};
  Link<grtx::modules::AnyHitDone> shaded{"shaded", 1, 2};

 private:
  /// Queues the round; false when no lane has it.
  bool call(std::uint16_t slot, std::uint32_t round) {
    const grtx::traces::RayGroup& group = groups_[slot];
    grtx::modules::TraceCall next{&group, round, slot, 0};
    for (unsigned lane = 0; lane < group.rays.size(); ++lane) {
      if (round < group.rays[lane].rounds.size()) next.lanes |= LaneMask{1} << lane;
    }
    if (next.lanes == 0) return false;
    to_call_.push_back(next);
    return true;
  }
  bool all_running() const { return std::all_of(running_.begin(), running_.end(), std::identity()); }

  const grtx::traces::Reader& reader_;
  std::vector<grtx::traces::RayGroup> groups_;  ///< by slot
  std::vector<bool> running_;
  std::uint64_t next_group_ = 0;
  std::deque<grtx::modules::TraceCall> to_call_;
  std::deque<std::pair<Cycle, grtx::modules::AnyHitDone>> shading_;
};

/// One port of the RT unit's memory: every request is answered after 20 cycles.
class Memory final : public grtx::modules::ClockedModule {
 public:
  Memory(const sc_core::sc_module_name& name, grtx::modules::ClockDomain& clock) : ClockedModule(name, clock) {
    requests.wake(&alarm_);
  }

  Cycle tick(Cycle now) override {
    while (const auto* request = requests.front(now)) {
      if (!responses.can_push(now)) return now + 1;
      grtx::modules::MemoryResponse response{.address = request->address,
                                             .tag = request->tag,
                                             .region = request->region,
                                             .write = request->write,
                                             .prefetch = request->prefetch};
      responses.push(now, response);
      requests.pop(now);
    }
    return requests.next_visible();
  }

  Link<grtx::modules::MemoryRequest> requests{"requests", 1, 4};
  Link<grtx::modules::MemoryResponse> responses{"responses", 19, 4096};
};

int replay(const std::string& path) {
  const grtx::traces::Reader reader(path);
  const grtx::traces::Header& header = reader.header();
  grtx::modules::set_time_resolution_to_fs();
  grtx::modules::ClockDomain clock("clock", 1000.0);
  constexpr unsigned kStackSectors = 128;  // of a ray, for what its stack spills
  const grtx::modules::MemoryMap map(header,
                                     {1, ShaderCore::kSlots, reader.totals().max_evictions_per_ray, kStackSectors});

  SerialRayBox* ray_box = nullptr;
  grtx::modules::RtUnitParts parts;
  parts.ray_box = [&ray_box](const char* name, const grtx::modules::RtUnitContext&) {
    auto made = std::make_unique<SerialRayBox>(name);
    ray_box = made.get();
    return made;
  };
  const std::unique_ptr<grtx::modules::RtUnitModule> made =
      grtx::modules::make_rt_unit("rt", grtx::modules::RtUnitConfig(), header, map, clock, 0, parts);
  grtx::modules::RtUnitModule& rt = *made;

  ShaderCore core("shader_core", clock, reader);
  rt.trace_call(core.calls);
  rt.trace_done(core.done);
  rt.any_hit_batch(core.batches);
  rt.any_hit_done(core.shaded);
  Memory nodes("nodes", clock), checkpoints("checkpoints", clock), prefetches("prefetches", clock),
      stacks("stacks", clock);
  rt.node_request(nodes.requests);
  rt.node_response(nodes.responses);
  if (rt.has_checkpoint()) {
    rt.checkpoint_request(checkpoints.requests);
    rt.checkpoint_response(checkpoints.responses);
  }
  if (rt.has_prefetcher()) {
    rt.prefetch_request(prefetches.requests);
    rt.prefetch_response(prefetches.responses);
  }
  if (rt.has_stack()) {
    rt.stack_request(stacks.requests);
    rt.stack_response(stacks.responses);
  }

  sc_core::sc_start();  // ends when no clocked module has work
  const std::uint64_t cycles = clock.cycle();
  std::printf("%llu cycles, %llu box tests, the box unit busy in %.1f %%\n", static_cast<unsigned long long>(cycles),
              static_cast<unsigned long long>(ray_box->served),
              100.0 * static_cast<double>(ray_box->busy_cycles) / static_cast<double>(cycles));
  const auto fail = [](const char* what) {
    std::fprintf(stderr, "own_ray_box: %s\n", what);
    return 1;
  };
  if (!core.finished() || !rt.idle()) return fail("the replay did not end");
  if (ray_box->served != reader.totals().visits_internal) return fail("not one box test a visit of an internal node");
  if (ray_box->busy_cycles > cycles) return fail("a serial unit cannot be busy longer than the run");
  return 0;
}

}  // namespace

int sc_main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "own_ray_box TRACE.grtx\n");
    return 2;
  }
  try {
    return replay(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "own_ray_box: %s\n", error.what());
    return 2;
  }
}
