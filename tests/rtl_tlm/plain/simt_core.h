// SPDX-License-Identifier: Apache-2.0
// Plain SIMT core: docs/model/simt_core.md.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "grtx/modules/simt/decide/shader_program.h"
#include "grtx/modules/simt/simt_core.h"
#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/shader_program.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

/// Between the SIMT core and one RT unit.
struct RtMessages {
  Channel<TraceCall> calls;
  Channel<TraceDone> dones;
  Channel<AnyHitBatch> batches;
  Channel<AnyHitDone> shaded;
  Channel<NodeFetchBatch> fetches;
  Channel<NodeFetchDone> fetched;
  RtMessages(unsigned latency, std::size_t capacity)
      : calls(latency, capacity),
        dones(latency, capacity),
        batches(latency, capacity),
        shaded(latency, capacity),
        fetches(latency, capacity),
        fetched(latency, capacity) {}
};

class SimtCore {
 public:
  using Config = modules::SimtCoreConfig;
  SimtCore(const Config& config, const traces::Header& header, const AddressMap& map, unsigned sm, unsigned slots,
           Channel<Launch>& launch, Channel<WarpEnded>& ended, std::vector<RtMessages*> rt, MemoryPort& memory)
      : config_(config),
        sm_(sm),
        header_(header),
        launch_(launch),
        ended_(ended),
        rt_(std::move(rt)),
        memory_(memory),
        scheduler_free_(config.schedulers, 0) {
    for (unsigned s = 0; s < slots; ++s) slots_.emplace_back(ShaderProgram(config, header_, map, sm, coloured_));
  }

  void tick(Cycle now) {
    take_memory_responses(now);
    now_ = now;
    take_messages(now);
    in_order([&](Slot& slot) {
      if (slot.phase && slot.phase->ready == now) finish_step(slot, now);
    });
    begin_phases(now);
    in_order([&](Slot& slot) {
      if (slot.phase && slot.phase->ready == kNotYet && !waits(*slot.phase)) arrive(now, slot);
    });
    send(now);
    count_states();
  }
  bool idle() const {
    return queue_.empty() && std::none_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.used; });
  }
  std::uint64_t instructions() const { return instructions_total_; }

  void report(Statistics& s) const {
    const std::string p = "gpu.simt.";
    s.add(p + "warps", warps_);
    s.add(p + "rounds", rounds_);
    s.add(p + "ray_rounds", counts_.ray_rounds);
    s.add(p + "any_hit.batches", batches_);
    s.add(p + "any_hit.calls", counts_.any_hit_calls);
    s.add(p + "intersection.batches", intersection_batches_);
    s.add(p + "intersection.calls", counts_.intersections);
    s.add(p + "evictions", counts_.evictions);
    s.add(p + "eviction_moves", counts_.eviction_moves);
    s.add(p + "processed", counts_.processed);
    s.add(p + "blended", counts_.blended);
    s.add(p + "k_buffer_mismatches", counts_.k_buffer_mismatches);
    s.add(p + "instructions.total", instructions_total_);
    for (std::size_t k = 0; k < kPhases; ++k) {
      s.add(p + "instructions." + kPhaseNames[k], instructions_[k]);
      s.add(p + "phases." + kPhaseNames[k], phases_[k]);
    }
    s.add(p + "issue.busy_cycles", instructions_total_);
    s.add(p + "issue.wait_cycles", issue_wait_);
    std::uint64_t resident = 0;
    for (std::size_t i = 0; i < kStates; ++i) {
      s.add(p + "warp_cycles." + kStateNames[i], state_cycles_[i]);
      resident += state_cycles_[i];
    }
    s.add(p + "resident_warp_cycles", resident);
    s.add(p + "lsu.sectors", sectors_);
    for (std::size_t r = 0; r < modules::kRegionCount; ++r) {
      if (modules::is_node(static_cast<Region>(r))) continue;  // the RT unit counts them as shader_fetch.sectors
      const std::string name(name_at<modules::Region>(r));
      s.add(p + "lsu.loads." + name, loads_[r]);
      s.add(p + "lsu.stores." + name, stores_[r]);
    }
    s.add(p + "lsu.load_instructions", load_instructions_);
    s.add(p + "lsu.store_instructions", store_instructions_);
    s.add(p + "lsu.blocked_cycles", blocked_);
    s.most(p + "lsu.deepest_queue", deepest_);
    s.add(p + "heap_cycles", counts_.heap_cycles);
    s.add(p + "colours_made", counts_.colours);
  }

 private:
  static constexpr Cycle kNotYet = ~Cycle{0};
  static constexpr std::size_t kPhases = std::size(kPhaseNames);
  enum class State { raygen, blend, any_hit, memory, trace, fetch, drain };
  static constexpr const char* kStateNames[] = {"raygen", "blend", "any_hit", "memory", "trace", "fetch", "drain"};
  static constexpr std::size_t kStates = std::size(kStateNames);
  enum class Step { prologue, evict_move, trace_call, tracing, sort, blend, epilogue, drain };

  struct Running {
    Running() {}  // clang wants one before the enclosing class is complete
    Phase phase{};
    std::size_t loads = 0;  ///< that are not back yet
    std::size_t step = 0;   ///< of the loads that wait for each other
    Cycle emptied = 0;      ///< its heaps
    Cycle ready = kNotYet;  ///< known from its arrival at the scheduler on
    AnyHitBatch batch;      ///< of an any_hit phase
    NodeFetchBatch fetch;   ///< of a node_fetch phase
  };
  struct Slot {
    explicit Slot(ShaderProgram p) : program(std::move(p)) {}
    ShaderProgram program;
    bool used = false;
    const traces::RayGroup* group = nullptr;
    Step step = Step::prologue;
    unsigned round = 0, pass = 0;
    std::optional<Running> phase;
    std::deque<AnyHitBatch> batches;
    std::vector<AnyHitBatch::Call> called;  ///< of the intersection shader
    std::deque<NodeFetchBatch> fetches;
    std::uint64_t stores = 0;  ///< not acknowledged
  };

  bool list() const { return header_.tracing == traces::Tracing::list; }
  unsigned number(const Slot& slot) const { return static_cast<unsigned>(&slot - slots_.data()); }
  RtMessages& rt_of(unsigned slot) { return *rt_[slot % rt_.size()]; }
  static bool is_any_hit(const Slot& slot) {
    return slot.phase &&
           (slot.phase->phase.kind == PhaseKind::any_hit || slot.phase->phase.kind == PhaseKind::node_fetch ||
            slot.phase->phase.kind == PhaseKind::intersection);
  }
  /// Slots with any-hit phases first, then the others; lower ones first.
  template <typename F>
  void in_order(F&& f) {
    std::vector<Slot*> order;
    for (const bool any_hit : {true, false}) {
      for (Slot& slot : slots_) {
        if (is_any_hit(slot) == any_hit) order.push_back(&slot);
      }
    }
    for (Slot* slot : order) f(*slot);
  }

  void take_memory_responses(Cycle now) {
    for (unsigned i = 0; i < config_.sectors_per_cycle && memory_.response.front(now) != nullptr; ++i) {
      const Access answer = memory_.response.pop(now);
      Slot& slot = slots_[answer.tag];
      if (!answer.write) {
        --slot.phase->loads;
      } else if (--slot.stores == 0 && slot.step == Step::drain) {
        end_warp(slot);
      }
    }
  }
  bool waits(const Running& running) const { return running.loads > 0 || running.emptied > now_; }
  void take_messages(Cycle now) {
    while (launch_.front(now) != nullptr) {
      const Launch launch = launch_.pop(now);
      if (launch.group->frame != frame_) coloured_.clear();
      frame_ = launch.group->frame;
      Slot& slot = slots_[launch.slot];
      slot.used = true;
      slot.group = launch.group;
      slot.step = Step::prologue;
      slot.round = 0;
      slot.program.start(*launch.group, launch.slot);
    }
    for (RtMessages* rt : rt_) {
      while (rt->dones.front(now) != nullptr) {
        Slot& slot = slots_[rt->dones.pop(now).slot];
        slot.pass = 0;
        const bool sorts = traces::collects_unsorted(header_.tracing) && slot.program.sort_passes(slot.round) > 0;
        slot.step = sorts ? Step::sort : Step::blend;
      }
      while (rt->batches.front(now) != nullptr) {
        const AnyHitBatch batch = rt->batches.pop(now);
        if (config_.heap.enabled) {
          Slot& slot = slots_[batch.slot];
          const Phase stored = slot.program.store_evicted(batch, counts_);
          enqueue(slot, stored.stores);
          slot.stores += stored.stores.size();
          store_instructions_ += stored.store_instructions;
          continue;
        }
        slots_[batch.slot].batches.push_back(batch);
      }
      while (rt->fetches.front(now) != nullptr) {
        const NodeFetchBatch batch = rt->fetches.pop(now);
        slots_[batch.slot].fetches.push_back(batch);
      }
    }
  }

  static std::size_t steps(const Phase& phase) { return std::max<std::size_t>(1, phase.steps.size()); }
  void finish_step(Slot& slot, Cycle now) {
    if (slot.phase->step + 1 == steps(slot.phase->phase)) {
      finish_phase(slot);
      return;
    }
    ++slot.phase->step;
    slot.phase->ready = kNotYet;
    load_step(slot, now);
  }
  /// The loads of the phase's step enter the queue.
  void load_step(Slot& slot, Cycle now) {
    const Phase& phase = slot.phase->phase;
    const std::size_t step = slot.phase->step;
    const std::size_t from = step == 0 ? 0 : phase.steps[step - 1];
    const std::size_t to = phase.steps.empty() ? phase.loads.size() : phase.steps[step];
    slot.phase->loads = to - from;
    slot.phase->emptied = now + phase.heap_cycles;
    enqueue(slot, {phase.loads.begin() + static_cast<std::ptrdiff_t>(from),
                   phase.loads.begin() + static_cast<std::ptrdiff_t>(to)});
  }
  void finish_phase(Slot& slot) {
    const Running done = std::move(*slot.phase);
    slot.phase.reset();
    enqueue(slot, done.phase.stores);
    slot.stores += done.phase.stores.size();
    const Step begin = header_.checkpoint ? Step::evict_move : Step::trace_call;
    switch (done.phase.kind) {
      case PhaseKind::intersection: {
        // The warp goes on as the any-hit shader of those that hit.
        AnyHitBatch hits = done.batch;
        hits.intersected = true;
        std::erase_if(hits.calls, [](const auto& call) { return !traces::calls_any_hit(call.outcome); });
        slot.called = done.batch.calls;
        if (hits.calls.empty()) {
          shaded_.push_back({number(slot), slot.called});
        } else {
          slot.batches.push_front(hits);
        }
        return;
      }
      case PhaseKind::any_hit:
        shaded_.push_back({number(slot), done.batch.intersected ? slot.called : done.batch.calls});
        return;
      case PhaseKind::node_fetch:
        fetched_.push_back({number(slot), {done.fetch.fetches}});
        return;
      case PhaseKind::prologue:
        slot.step = slot.program.has_round(0) ? begin : Step::epilogue;
        return;
      case PhaseKind::evict_move:
        slot.step = Step::trace_call;
        return;
      case PhaseKind::trace_call:
        calls_.push_back({slot.group, number(slot), slot.round});
        slot.step = Step::tracing;
        return;
      case PhaseKind::sort:
        ++slot.pass;
        if (list() || slot.pass == slot.program.sort_passes(slot.round)) slot.step = Step::blend;
        return;
      case PhaseKind::blend:
        slot.program.blend_ends();
        if (list() && slot.pass < slot.program.sort_passes(slot.round)) {
          slot.step = Step::sort;
          return;
        }
        ++slot.round;
        slot.step = slot.program.has_round(slot.round) ? begin : Step::epilogue;
        return;
      case PhaseKind::epilogue:
        slot.step = Step::drain;
        if (slot.stores == 0) end_warp(slot);
        return;
    }
  }
  void end_warp(Slot& slot) {
    ends_.push_back({number(slot)});
    slot.used = false;
    ++warps_;
  }

  void begin_phases(Cycle now) {
    for (const bool any_hit : {true, false}) {
      for (Slot& slot : slots_) {
        if (!slot.used || slot.phase) continue;
        const bool waiting = !slot.batches.empty() || !slot.fetches.empty();
        if (waiting != any_hit) continue;
        if (!waiting && (slot.step == Step::tracing || slot.step == Step::drain)) continue;
        slot.phase.emplace();
        slot.phase->phase = next_phase(slot);
        begin(slot, now);
      }
    }
  }
  Phase next_phase(Slot& slot) {
    ShaderProgram& program = slot.program;
    if (!slot.batches.empty()) {
      slot.phase->batch = slot.batches.front();
      slot.batches.pop_front();
      if (traces::has_box_leaves(header_.accel) && !slot.phase->batch.intersected) {
        ++intersection_batches_;
        return program.intersection(slot.phase->batch, counts_);
      }
      ++batches_;
      return program.any_hit(slot.phase->batch, counts_);
    }
    if (!slot.fetches.empty()) {
      slot.phase->fetch = slot.fetches.front();
      slot.fetches.pop_front();
      return program.node_fetch(slot.phase->fetch);
    }
    switch (slot.step) {
      case Step::prologue:
        return program.prologue();
      case Step::evict_move:
        return program.evict_move(slot.round, counts_);
      case Step::trace_call:
        ++rounds_;
        if (!header_.checkpoint) program.begin_round(slot.round, counts_);
        return program.trace_call();
      case Step::sort:
        return program.sort(slot.round, slot.pass);
      case Step::blend:
        return program.blend(slot.round, slot.pass, counts_);
      default:
        return program.epilogue();
    }
  }
  void begin(Slot& slot, Cycle now) {
    Phase& phase = slot.phase->phase;
    const auto kind = static_cast<std::size_t>(phase.kind);
    if (!config_.costs.dependent_loads) phase.steps.clear();
    load_step(slot, now);
    ++phases_[kind];
    instructions_[kind] += phase.instructions;
    instructions_total_ += phase.instructions;
    load_instructions_ += phase.load_instructions;
    store_instructions_ += phase.store_instructions;
  }
  void enqueue(const Slot& slot, const std::vector<Access>& accesses) {
    for (Access access : accesses) {
      access.tag = number(slot);
      queue_.push_back(access);
    }
    deepest_ = std::max<std::uint64_t>(deepest_, queue_.size());
  }
  std::uint64_t instructions_of_step(const Running& running) const {
    const std::uint64_t n = running.phase.instructions, count = steps(running.phase);
    const std::uint64_t each = std::min<std::uint64_t>(config_.costs.any_hit_per_shift, n / count);
    return running.step + 1 < count ? each : n - each * (count - 1);
  }
  void arrive(Cycle now, Slot& slot) {
    const unsigned scheduler = number(slot) % config_.schedulers;
    Cycle& free = scheduler_free_[scheduler];
    free = std::max(now + 1, free);
    issue_wait_ += free - (now + 1);
    free += instructions_of_step(*slot.phase);
    slot.phase->ready = free + config_.instruction_latency;
  }

  void send(Cycle now) {
    if (!queue_.empty() && !memory_.request.has_room(now)) ++blocked_;
    for (unsigned i = 0; i < config_.sectors_per_cycle && !queue_.empty() && memory_.request.has_room(now); ++i) {
      const Access access = queue_.front();
      queue_.pop_front();
      memory_.request.push(now, access);
      ++sectors_;
      ++(access.write ? stores_ : loads_)[modules::index(access.region)];
    }
    if (!calls_.empty() && rt_of(calls_.front().slot).calls.has_room(now)) {
      rt_of(calls_.front().slot).calls.push(now, calls_.front());
      calls_.pop_front();
    }
    if (!shaded_.empty() && rt_of(shaded_.front().slot).shaded.has_room(now)) {
      rt_of(shaded_.front().slot).shaded.push(now, shaded_.front());
      shaded_.pop_front();
    }
    if (!fetched_.empty() && rt_of(fetched_.front().first).fetched.has_room(now)) {
      rt_of(fetched_.front().first).fetched.push(now, fetched_.front().second);
      fetched_.pop_front();
    }
    if (!ends_.empty() && ended_.has_room(now)) {
      ended_.push(now, ends_.front());
      ends_.pop_front();
    }
  }

  State state(const Slot& slot) const {
    if (!slot.phase) return slot.step == Step::drain ? State::drain : State::trace;
    if (slot.phase->ready == kNotYet && waits(*slot.phase)) return State::memory;
    switch (slot.phase->phase.kind) {
      case PhaseKind::any_hit:
      case PhaseKind::intersection:
        return State::any_hit;
      case PhaseKind::node_fetch:
        return State::fetch;
      case PhaseKind::blend:
        return State::blend;
      default:
        return State::raygen;
    }
  }
  void count_states() {
    for (const Slot& slot : slots_) {
      if (slot.used) ++state_cycles_[static_cast<std::size_t>(state(slot))];
    }
  }

  Config config_;
  unsigned sm_;
  const traces::Header& header_;
  Channel<Launch>& launch_;
  Channel<WarpEnded>& ended_;
  std::vector<RtMessages*> rt_;
  MemoryPort& memory_;
  std::vector<Slot> slots_;
  std::set<std::uint64_t> coloured_;  ///< Gaussians whose colour is in the SM's table
  std::uint32_t frame_ = 0;
  std::vector<Cycle> scheduler_free_;
  std::deque<Access> queue_;  ///< of the load-store unit
  std::deque<TraceCall> calls_;
  std::deque<AnyHitDone> shaded_;
  std::deque<std::pair<unsigned, NodeFetchDone>> fetched_;  ///< with the slot
  std::deque<WarpEnded> ends_;

  Cycle now_ = 0;
  ShaderCounts counts_;
  std::array<std::uint64_t, kPhases> phases_{}, instructions_{};
  std::array<std::uint64_t, kStates> state_cycles_{};
  std::array<std::uint64_t, modules::kRegionCount> loads_{}, stores_{};
  std::uint64_t warps_ = 0, rounds_ = 0, batches_ = 0, intersection_batches_ = 0, instructions_total_ = 0,
                issue_wait_ = 0;
  std::uint64_t sectors_ = 0, load_instructions_ = 0, store_instructions_ = 0, blocked_ = 0, deepest_ = 0;
};

}  // namespace grtx::sim::plain
