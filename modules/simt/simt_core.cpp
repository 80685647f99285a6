// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/simt_core.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/make_anew.h"
#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/messages/lane_loop.h"

namespace grtx::modules {
namespace {

// Kept out of accept_response(), which the compiler inlines if it is short.
[[noreturn, gnu::cold, gnu::noinline]] void report_unasked(const char* unit, std::uint32_t slot) {
  unit_fault(unit, "the L1 has answered a request of warp slot " + std::to_string(slot) + ", which made none");
}

const SimtCoreConfig& checked(const SimtCoreConfig& config) {
  check_resident_warps(config.resident_warps);
  require_allowed("simt", config);
  return config;
}

}  // namespace

SimtCore::SimtCore(const sc_core::sc_module_name& name, ClockDomain& domain, const SimtCoreConfig& config,
                   const traces::Header& header, const MemoryMap& map)
    : SimtCoreModule(name, domain),
      config_(checked(config)),
      header_(header),
      map_(map),
      program_(header, map, config.costs, config.sm, config.resident_warps, config.heap),
      issue_slots_(config.schedulers, config.instruction_latency),
      lsu_(config.resident_warps, config.l1_client),
      slots_(config.resident_warps),
      trace_calls_(config.resident_warps),
      any_hits_done_(static_cast<std::size_t>(config.resident_warps) * kMaxLanes),
      nodes_fetched_(static_cast<std::size_t>(config.resident_warps) * kMaxLanes),
      ends_(config.resident_warps) {
  waiting_.reserve(config.resident_warps);
}

void SimtCore::restart(Caches) {
  make_anew(program_, header_, map_, config_.costs, config_.sm, config_.resident_warps, config_.heap);
  issue_slots_ = IssueSlots(config_.schedulers, config_.instruction_latency);
  lsu_ = LoadStoreUnit(config_.resident_warps, config_.l1_client);
  std::fill(slots_.begin(), slots_.end(), Slot());
  starting_service_ = starting_ray_generation_ = loaded_ = 0;
  waiting_.clear();
  trace_calls_.clear();
  any_hits_done_.clear();
  nodes_fetched_.clear();
  ends_.clear();
  next_ready_ = next_drained_ = kNever;
  last_active_ = 0;
  counters_ = {};
}

void SimtCore::start_of_simulation() {
  launch_ = reader_of(launch);
  ended_ = writer_of(ended);
  const auto units = static_cast<std::size_t>(trace_call.size());
  for (std::size_t u = 0; u < units; ++u) {
    const auto i = static_cast<int>(u);
    RtLinks links{LinkWriter(trace_call[i]),
                  LinkReader(trace_done[i]),
                  LinkReader(any_hit_batch[i]),
                  LinkWriter(any_hit_done[i]),
                  {},
                  {}};
    if (node_fetch.size() > 0) {
      links.node_fetch = LinkReader(node_fetch[i]);
      links.node_fetch_done = LinkWriter(node_fetch_done[i]);
      links.node_fetch.wake(&alarm_);
    }
    links.trace_done.wake(&alarm_);
    links.any_hit_batch.wake(&alarm_);
    rt_.push_back(links);
  }
  memory_request_ = writer_of(memory_request);
  memory_response_ = reader_of(memory_response);
  launch_.wake(&alarm_);
  memory_response_.wake(&alarm_);
}

Cycle SimtCore::earliest_due() const {
  if (!lsu_.empty() || !trace_calls_.empty() || !any_hits_done_.empty() || !nodes_fetched_.empty() || !ends_.empty()) {
    return 0;
  }
  Cycle due = std::min({next_ready_, next_drained_, memory_response_.next_visible(), launch_.next_visible()});
  for (const RtLinks& rt : rt_) {
    due = std::min({due, rt.any_hit_batch.next_visible(), rt.trace_done.next_visible()});
    if (rt.node_fetch) due = std::min(due, rt.node_fetch.next_visible());
  }
  return due;
}

Cycle SimtCore::tick(Cycle now) {
  Cycle due = earliest_due();
  if (due <= now) {
    last_active_ = now;
    if (memory_response_.next_visible() <= now) accept_response(now);
    if (next_drained_ <= now) finish_drains(now);
    accept_messages(now);
    if (next_ready_ <= now) finish_phases(now);
    // Services for the RT unit have priority throughout, because its lanes wait for them.
    for_each_bit(std::exchange(starting_service_, 0), [&](unsigned slot) { start_service(slot, now); });
    for_each_bit(std::exchange(starting_ray_generation_, 0), [&](unsigned slot) { start_ray_generation(slot, now); });
    const WarpMask loaded = std::exchange(loaded_, 0);
    WarpMask ray_generation = 0;
    for_each_bit(loaded, [&](unsigned slot) {
      if (slots_[slot].service != Service::none) {
        issue(slot, now);
      } else {
        ray_generation |= bit(slot);
      }
    });
    for_each_bit(ray_generation, [&](unsigned slot) { issue(slot, now); });
    send(now);
    due = std::max(earliest_due(), now + 1);
  }
  return due;
}

void SimtCore::accept_response(Cycle now) {
  for (unsigned i = 0; i < config_.sectors_per_cycle; ++i) {
    const MemoryResponse* response = memory_response_.front(now);
    if (response == nullptr) return;
    if (!lsu_.expects(*response)) [[unlikely]]
      report_unasked(name(), response->tag);
    const bool write = response->write;
    const unsigned slot = lsu_.receive(*response);
    memory_response_.pop(now);
    if (!write && lsu_.loads_pending(slot) == 0 && slots_[slot].drained == 0) loaded_ |= bit(slot);
    if (write) end_if_drained(slot, now);
  }
}

void SimtCore::finish_drains(Cycle now) {
  next_drained_ = kNever;
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    Cycle& back = slots_[slot].drained;
    if (back == 0) continue;
    if (back > now) {
      next_drained_ = std::min(next_drained_, back);
      continue;
    }
    back = 0;
    if (lsu_.loads_pending(slot) == 0) loaded_ |= bit(slot);
  }
}

void SimtCore::accept_messages(Cycle now) {
  for (const LaunchWarp* warp; (warp = launch_.front(now)) != nullptr; launch_.pop(now)) {
    Slot& slot = slots_[warp->slot];
    assert(slot.step == Step::free);
    program_.begin(warp->slot, *warp->group);
    slot.step = Step::prologue;
    slot.activity = WarpActivity::raygen;
    slot.since = now;
    starting_ray_generation_ |= bit(warp->slot);
  }
  for (RtLinks& rt : rt_) {
    for (const TraceDone* done; (done = rt.trace_done.front(now)) != nullptr; rt.trace_done.pop(now)) {
      Slot& slot = slots_[done->slot];
      assert(slot.step == Step::tracing && slot.service == Service::none && done->round == program_.round(done->slot));
      slot.step = program_.sorts(done->slot) ? Step::sort : Step::blend;
      starting_ray_generation_ |= bit(done->slot);
    }
    for (const AnyHitBatch* batch; (batch = rt.any_hit_batch.front(now)) != nullptr; rt.any_hit_batch.pop(now)) {
      if (program_.has_heaps()) {
        store_evicted(*batch);
        continue;
      }
      assert(slots_[batch->slot].step == Step::tracing && batch->round == program_.round(batch->slot));
      waiting_.add(*batch);
      if (slots_[batch->slot].service == Service::none) starting_service_ |= bit(batch->slot);
    }
    if (!rt.node_fetch) continue;
    for (const NodeFetchBatch* batch; (batch = rt.node_fetch.front(now)) != nullptr; rt.node_fetch.pop(now)) {
      assert(slots_[batch->slot].step == Step::tracing);
      waiting_.add(*batch);
      if (slots_[batch->slot].service == Service::none) starting_service_ |= bit(batch->slot);
    }
  }
}

void SimtCore::finish_phases(Cycle now) {
  WarpMask service = 0;
  WarpMask ray_generation = 0;
  next_ready_ = kNever;
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    const Cycle ready = slots_[slot].ready;
    if (ready <= now) {
      (slots_[slot].service != Service::none ? service : ray_generation) |= bit(slot);
      slots_[slot].ready = kNever;
    } else {
      next_ready_ = std::min(next_ready_, ready);
    }
  }
  for_each_bit(service, [&](unsigned slot) { more_steps(slot) ? load_step(slot, now) : finish_service(slot, now); });
  for_each_bit(ray_generation, [&](unsigned slot) {
    store(slot);
    finish_ray_generation(slot, now);
  });
}

void SimtCore::finish_service(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  store(slot);
  if (warp.service == Service::intersection && warp.hits.lanes != 0) {
    starting_service_ |= bit(slot);
    return;
  }
  if (warp.service != Service::node_fetch) {
    AnyHitDone done;
    done.slot = static_cast<std::uint16_t>(slot);
    done.lanes = warp.any_hit_lanes;
    any_hits_done_.push(done);
  } else {
    nodes_fetched_.push({static_cast<std::uint16_t>(slot), warp.fetched});
  }
  warp.service = Service::none;
  enter(slot, WarpActivity::trace, now);
  if (waiting_.waits(slot)) starting_service_ |= bit(slot);
}

void SimtCore::finish_ray_generation(unsigned slot, Cycle now) {
  switch (slots_[slot].step) {
    case Step::prologue:
      next_round(slot);
      break;
    case Step::blend:
      program_.publish_colours(slot);
      if (!program_.blends_on(slot)) return next_round(slot);
      slots_[slot].step = Step::sort;
      starting_ray_generation_ |= bit(slot);
      break;
    case Step::evict_move:
      slots_[slot].step = Step::trace_call;
      starting_ray_generation_ |= bit(slot);
      break;
    case Step::sort:
      slots_[slot].step = program_.sorts(slot) ? Step::sort : Step::blend;
      starting_ray_generation_ |= bit(slot);
      break;
    case Step::trace_call:
      slots_[slot].step = Step::tracing;
      enter(slot, WarpActivity::trace, now);
      trace_calls_.push(static_cast<std::uint16_t>(slot));
      break;
    case Step::epilogue:
      slots_[slot].step = Step::draining;
      enter(slot, WarpActivity::drain, now);
      end_if_drained(slot, now);
      break;
    default:
      assert(false);
  }
}

void SimtCore::next_round(unsigned slot) {
  if (program_.active_lanes(slot) == 0) {
    slots_[slot].step = Step::epilogue;
  } else {
    slots_[slot].step = program_.moves_evictions() ? Step::evict_move : Step::trace_call;
  }
  starting_ray_generation_ |= bit(slot);
}

// An intersection shader is followed by the any-hit shader for its hits.
void SimtCore::start_service(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  if (warp.service == Service::intersection) {
    const AnyHitBatch hits = warp.hits;
    warp.hits.lanes = 0;
    return start_any_hit(slot, hits, now);
  }
  assert(warp.service == Service::none);
  if (const std::optional<AnyHitBatch> called = waiting_.take_any_hit(slot)) {
    warp.any_hit_lanes = called->lanes;
    if (!program_.intersects()) return start_any_hit(slot, *called, now);
    warp.service = Service::intersection;
    warp.hits = ShaderProgram::hits_of(*called);
    program_.intersection(*called, phase_);
  } else {
    const std::optional<NodeFetchBatch> fetch = waiting_.take_node_fetch(slot);
    assert(fetch.has_value());
    warp.service = Service::node_fetch;
    warp.fetched = {fetch->entry, fetch->fetches};
    program_.node_fetch(*fetch, phase_);
  }
  load(slot, now);
}

void SimtCore::start_any_hit(unsigned slot, const AnyHitBatch& batch, Cycle now) {
  slots_[slot].service = Service::any_hit;
  program_.any_hit(batch, phase_);
  load(slot, now);
}

void SimtCore::store_evicted(const AnyHitBatch& batch) {
  program_.store_evicted(batch, phase_);
  lsu_.enqueue(batch.slot, phase_.stores, true);
}

void SimtCore::fill_phase(unsigned slot) {
  switch (slots_[slot].step) {
    case Step::prologue:
      program_.prologue(slot, phase_);
      break;
    case Step::evict_move:
      program_.evict_move(slot, phase_);
      break;
    case Step::trace_call:
      program_.trace_call(slot, phase_);
      break;
    case Step::sort:
      program_.sort(slot, phase_);
      break;
    case Step::blend:
      program_.blend(slot, phase_);
      break;
    case Step::epilogue:
      program_.epilogue(slot, phase_);
      break;
    default:
      assert(false);
  }
}

void SimtCore::start_ray_generation(unsigned slot, Cycle now) {
  fill_phase(slot);
  load(slot, now);
}

void SimtCore::load(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  warp.kind = phase_.kind;
  warp.instructions = phase_.instructions;
  warp.stores.swap(phase_.stores);
  warp.steps.swap(phase_.steps);
  if (!warp.steps.empty()) {
    warp.loads.swap(phase_.loads);
    warp.next_step = 0;
    warp.step_instructions = phase_.step_instructions;
    load_step(slot, now);
  } else if (phase_.loads.empty() && phase_.delay == 0) {
    loaded_ |= bit(slot);
  } else {
    if (phase_.delay > 0) {
      warp.drained = now + phase_.delay;
      next_drained_ = std::min(next_drained_, warp.drained);
    }
    send_loads(slot, phase_.loads, now);
  }
}

void SimtCore::load_step(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  const std::uint32_t begin = warp.next_step == 0 ? 0 : warp.steps[warp.next_step - 1];
  const std::uint32_t end = warp.steps[warp.next_step++];
  send_loads(slot, std::span(warp.loads).subspan(begin, end - begin), now);
}

void SimtCore::send_loads(unsigned slot, std::span<const SectorAccess> loads, Cycle now) {
  lsu_.enqueue(slot, loads, false);
  enter(slot, WarpActivity::memory, now);
}

void SimtCore::issue(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  enter(slot, activity_of(warp.kind), now);
  const bool last = !more_steps(slot);
  const std::uint64_t instructions = last ? warp.instructions : warp.step_instructions;
  warp.instructions -= instructions;
  warp.ready = issue_slots_.reserve(slot, instructions, now);
  next_ready_ = std::min(next_ready_, warp.ready);
  counters_.instructions[static_cast<std::size_t>(warp.kind)] += instructions;
  if (last) ++counters_.phases[static_cast<std::size_t>(warp.kind)];
}

void SimtCore::store(unsigned slot) {
  if (!slots_[slot].stores.empty()) lsu_.enqueue(slot, slots_[slot].stores, true);
}

void SimtCore::end_if_drained(unsigned slot, Cycle now) {
  if (slots_[slot].step != Step::draining || lsu_.stores_pending(slot) != 0) return;
  slots_[slot].step = Step::free;
  counters_.warp_cycles[static_cast<std::size_t>(slots_[slot].activity)] += now - slots_[slot].since;
  ++counters_.warps;
  ends_.push(static_cast<std::uint16_t>(slot));
}

void SimtCore::send(Cycle now) {
  if (!lsu_.empty()) lsu_.send(now, memory_request_, config_.sectors_per_cycle);
  const auto rt_of = [this](std::uint16_t slot) -> RtLinks& { return rt_[slot % rt_.size()]; };
  if (!any_hits_done_.empty()) {
    LinkWriter<AnyHitDone>& link = rt_of(any_hits_done_.front().slot).any_hit_done;
    if (link.can_push(now)) {
      link.push(now, any_hits_done_.front());
      any_hits_done_.pop();
    }
  }
  if (!nodes_fetched_.empty()) {
    LinkWriter<NodeFetchDone>& link = rt_of(nodes_fetched_.front().slot).node_fetch_done;
    if (link.can_push(now)) {
      link.push(now, nodes_fetched_.front().done);
      nodes_fetched_.pop();
    }
  }
  if (!trace_calls_.empty() && rt_of(trace_calls_.front()).trace_call.can_push(now)) {
    TraceCall call;
    call.slot = trace_calls_.front();
    call.group = program_.group(call.slot);
    call.round = program_.round(call.slot);
    call.lanes = program_.active_lanes(call.slot);
    rt_of(call.slot).trace_call.push(now, call);
    trace_calls_.pop();
  }
  if (!ends_.empty() && ended_.can_push(now)) {
    WarpEnded end;
    end.slot = ends_.front();
    ended_.push(now, end);
    ends_.pop();
  }
}

void SimtCore::enter(unsigned slot, WarpActivity activity, Cycle now) {
  Slot& warp = slots_[slot];
  counters_.warp_cycles[static_cast<std::size_t>(warp.activity)] += now - warp.since;
  warp.activity = activity;
  warp.since = now;
}

unsigned SimtCore::resident() const {
  return static_cast<unsigned>(
      std::count_if(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.step != Step::free; }));
}

bool SimtCore::idle() const {
  return resident() == 0 && lsu_.idle() && waiting_.empty() && trace_calls_.empty() && any_hits_done_.empty() &&
         nodes_fetched_.empty() && ends_.empty();
}

SimtCounters SimtCore::counters() const {
  SimtCounters counters = counters_;
  for (const Slot& slot : slots_) {
    if (slot.step == Step::free) continue;
    counters.warp_cycles[static_cast<std::size_t>(slot.activity)] += clock_.cycle() - slot.since;
  }
  counters.issue_busy_cycles = issue_slots_.busy_cycles();
  counters.issue_wait_cycles = issue_slots_.wait_cycles();
  counters.shader = program_.counters();
  counters.memory = lsu_.counters();
  return counters;
}

Inventory SimtCore::inventory() const {
  // Lane count and register file dominate; the control of a warp is its program counter, lane mask and scoreboard.
  constexpr std::uint64_t kWarpControlBits = 32 + kMaxLanes + 64;
  const std::uint64_t lanes = static_cast<std::uint64_t>(config_.schedulers) * kMaxLanes;
  Inventory inventory;
  inventory.module = name();
  inventory.storage.push_back(
      {"register_file", StorageKind::ram, config_.register_file.registers * 32, 3, 1, false, 32 * kMaxLanes});
  inventory.storage.push_back(
      {"warp_control", StorageKind::flip_flop, config_.resident_warps * kWarpControlBits, 1, 1, false});
  inventory.operators.push_back({"fp_fma", 32, lanes});
  inventory.operators.push_back({"int_add", 32, lanes});
  inventory.operators.push_back({"fp_compare", 32, lanes});
  return inventory;
}

void SimtCore::dump_state(std::ostream& out) const {
  out << name() << ": last active in cycle " << last_active_ << ", " << resident() << " warps resident, "
      << waiting_.any_hits() << " any-hit batches and " << waiting_.node_fetches()
      << " node fetches waiting; to send: " << trace_calls_.size() << " trace calls, " << any_hits_done_.size()
      << " any-hits done, " << nodes_fetched_.size() << " nodes fetched, " << ends_.size() << " ends\n";
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    const Slot& warp = slots_[slot];
    if (warp.step == Step::free) continue;
    out << "  slot " << slot << ": group " << program_.group(slot)->index << " round " << program_.round(slot) << " "
        << name_of(warp.step)
        << (warp.service == Service::any_hit        ? " in any-hit"
            : warp.service == Service::node_fetch   ? " fetching nodes"
            : warp.service == Service::intersection ? " in intersection"
                                                    : "")
        << " since cycle " << warp.since << ", loads pending " << lsu_.loads_pending(slot) << ", stores pending "
        << lsu_.stores_pending(slot) << "\n";
  }
  lsu_.dump_state(out);
}

std::unique_ptr<SimtCoreModule> make_simt_core(const sc_core::sc_module_name& name, ClockDomain& domain,
                                               const SimtCoreConfig& config, const traces::Header& header,
                                               const MemoryMap& map) {
  return std::make_unique<SimtCore>(name, domain, config, header, map);
}

}  // namespace grtx::modules
