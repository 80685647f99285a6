#include "modules/simt_core.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <ostream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "modules/lane_loop.h"

namespace grtx::modules {
namespace {

constexpr unsigned kMaxResidentWarps = 64;  // bits of a mask

const SimtCoreConfig& checked(const SimtCoreConfig& config) {
  if (config.resident_warps == 0 || config.resident_warps > kMaxResidentWarps) {
    throw Error("configuration", "resident_warps", "must be 1 to " + std::to_string(kMaxResidentWarps));
  }
  if (config.schedulers == 0) throw Error("configuration", "schedulers", "must be at least 1");
  return config;
}

constexpr std::array<std::string_view, 9> kStepNames = {"free",    "prologue", "evict_move", "trace_call", "tracing",
                                                        "sort",    "blend",    "epilogue",   "draining"};

constexpr WarpActivity executing(PhaseKind kind) {
  if (kind == PhaseKind::blend) return WarpActivity::blend;
  if (kind == PhaseKind::any_hit) return WarpActivity::any_hit;
  return WarpActivity::raygen;
}

}  // namespace

SimtCore::SimtCore(const sc_core::sc_module_name& name, ClockDomain& domain, const SimtCoreConfig& config,
                   const traces::Header& header, const MemoryMap& map)
    : sc_module(name),
      domain_(domain),
      alarm_(domain, this, [](void* module) { static_cast<SimtCore*>(module)->on_tick(); }),
      config_(checked(config)),
      program_(header, map, config.costs, config.sm, config.resident_warps),
      issue_slots_(config.schedulers, config.instruction_latency),
      lsu_(config.resident_warps, config.l1_client),
      slots_(config.resident_warps),
      trace_calls_(config.resident_warps),
      any_hits_done_(static_cast<std::size_t>(config.resident_warps) * kMaxLanes),
      ends_(config.resident_warps) {
  batches_.reserve(config.resident_warps);
  SC_METHOD(on_tick);
  sensitive << alarm_.event();
  dont_initialize();
}

void SimtCore::start_of_simulation() {
  launch_ = launch.operator->();
  ended_ = ended.operator->();
  trace_call_ = trace_call.operator->();
  trace_done_ = trace_done.operator->();
  any_hit_batch_ = any_hit_batch.operator->();
  any_hit_done_ = any_hit_done.operator->();
  memory_request_ = memory_request.operator->();
  memory_response_ = memory_response.operator->();
  launch_->wake(&alarm_);
  trace_done_->wake(&alarm_);
  any_hit_batch_->wake(&alarm_);
  memory_response_->wake(&alarm_);
}

Cycle SimtCore::earliest_due() const {
  if (!lsu_.empty() || !trace_calls_.empty() || !any_hits_done_.empty() || !ends_.empty()) return 0;
  return std::min({next_ready_, memory_response_->next_visible(), any_hit_batch_->next_visible(),
                   trace_done_->next_visible(), launch_->next_visible()});
}

void SimtCore::on_tick() {
  const Cycle now = domain_.cycle();
  Cycle due = earliest_due();
  if (due <= now) {
    accept_response(now);
    accept_messages(now);
    finish_phases(now);
    // Any-hit shaders go first everywhere: lanes wait for them in the RT unit.
    for_each_bit(std::exchange(starting_any_hit_, 0), [&](unsigned slot) { start_any_hit(slot, now); });
    for_each_bit(std::exchange(starting_ray_generation_, 0), [&](unsigned slot) { start_ray_generation(slot, now); });
    const LaneMask loaded = std::exchange(loaded_, 0);
    LaneMask ray_generation = 0;
    for_each_bit(loaded, [&](unsigned slot) {
      if (slots_[slot].in_any_hit) {
        issue(slot, now);
      } else {
        ray_generation |= bit(slot);
      }
    });
    for_each_bit(ray_generation, [&](unsigned slot) { issue(slot, now); });
    send(now);
    due = std::max(earliest_due(), now + 1);
  }
  alarm_.request(due);
}

void SimtCore::accept_response(Cycle now) {
  const MemoryResponse* response = memory_response_->front(now);
  if (response == nullptr) return;
  const bool write = response->write;
  const unsigned slot = lsu_.receive(*response);
  memory_response_->pop(now);
  if (!write && lsu_.loads_pending(slot) == 0) loaded_ |= bit(slot);
  if (write) end_if_drained(slot, now);
}

void SimtCore::accept_messages(Cycle now) {
  for (const LaunchWarp* warp; (warp = launch_->front(now)) != nullptr; launch_->pop(now)) {
    Slot& slot = slots_[warp->slot];
    assert(slot.step == Step::free);
    program_.begin(warp->slot, *warp->group);
    slot.step = Step::prologue;
    slot.activity = WarpActivity::raygen;
    slot.since = now;
    starting_ray_generation_ |= bit(warp->slot);
  }
  for (const TraceDone* done; (done = trace_done_->front(now)) != nullptr; trace_done_->pop(now)) {
    Slot& slot = slots_[done->slot];
    assert(slot.step == Step::tracing && !slot.in_any_hit && done->round == program_.round(done->slot));
    slot.step = program_.sorts(done->slot) ? Step::sort : Step::blend;
    starting_ray_generation_ |= bit(done->slot);
  }
  for (const AnyHitBatch* batch; (batch = any_hit_batch_->front(now)) != nullptr; any_hit_batch_->pop(now)) {
    const Slot& slot = slots_[batch->slot];
    assert(slot.step == Step::tracing && batch->round == program_.round(batch->slot));
    batches_.push_back(*batch);
    if (!slot.in_any_hit) starting_any_hit_ |= bit(batch->slot);
  }
}

void SimtCore::finish_phases(Cycle now) {
  if (next_ready_ > now) return;
  LaneMask any_hit = 0;
  LaneMask ray_generation = 0;
  next_ready_ = kNever;
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    const Cycle ready = slots_[slot].ready;
    if (ready <= now) {
      (slots_[slot].in_any_hit ? any_hit : ray_generation) |= bit(slot);
      slots_[slot].ready = kNever;
    } else {
      next_ready_ = std::min(next_ready_, ready);
    }
  }
  for_each_bit(any_hit, [&](unsigned slot) {
    store(slot);
    AnyHitDone done;
    done.slot = static_cast<std::uint16_t>(slot);
    done.lanes = slots_[slot].any_hit_lanes;
    any_hits_done_.push(done);
    slots_[slot].in_any_hit = false;
    enter(slot, WarpActivity::trace, now);
    const auto same_warp = [&](const AnyHitBatch& batch) { return batch.slot == slot; };
    if (std::any_of(batches_.begin(), batches_.end(), same_warp)) starting_any_hit_ |= bit(slot);
  });
  for_each_bit(ray_generation, [&](unsigned slot) {
    store(slot);
    finish_ray_generation(slot, now);
  });
}

void SimtCore::finish_ray_generation(unsigned slot, Cycle now) {
  switch (slots_[slot].step) {
    case Step::prologue:
    case Step::blend:
      next_round(slot);
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

void SimtCore::start_any_hit(unsigned slot, Cycle now) {
  const auto batch =
      std::find_if(batches_.begin(), batches_.end(), [&](const AnyHitBatch& waiting) { return waiting.slot == slot; });
  assert(batch != batches_.end() && !slots_[slot].in_any_hit);
  slots_[slot].in_any_hit = true;
  slots_[slot].any_hit_lanes = batch->lanes;
  program_.any_hit(*batch, phase_);
  batches_.erase(batch);
  load(slot, now);
}

void SimtCore::start_ray_generation(unsigned slot, Cycle now) {
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
  load(slot, now);
}

void SimtCore::load(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  warp.kind = phase_.kind;
  warp.instructions = phase_.instructions;
  warp.stores.swap(phase_.stores);
  if (phase_.loads.empty()) {
    loaded_ |= bit(slot);
  } else {
    lsu_.enqueue(slot, phase_.loads, false);
    enter(slot, WarpActivity::memory, now);
  }
}

void SimtCore::issue(unsigned slot, Cycle now) {
  Slot& warp = slots_[slot];
  enter(slot, executing(warp.kind), now);
  warp.ready = issue_slots_.reserve(slot, warp.instructions, now);
  next_ready_ = std::min(next_ready_, warp.ready);
  counters_.instructions[static_cast<std::size_t>(warp.kind)] += warp.instructions;
  ++counters_.phases[static_cast<std::size_t>(warp.kind)];
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
  if (lsu_.send(now, *memory_request_)) domain_.request(now + memory_request_->latency());
  if (!any_hits_done_.empty() && any_hit_done_->can_push(now)) {
    any_hit_done_->push(now, any_hits_done_.front());
    any_hits_done_.pop();
    domain_.request(now + any_hit_done_->latency());
  }
  if (!trace_calls_.empty() && trace_call_->can_push(now)) {
    TraceCall call;
    call.slot = trace_calls_.front();
    call.group = program_.group(call.slot);
    call.round = program_.round(call.slot);
    call.lanes = program_.active_lanes(call.slot);
    trace_call_->push(now, call);
    trace_calls_.pop();
    domain_.request(now + trace_call_->latency());
  }
  if (!ends_.empty() && ended_->can_push(now)) {
    WarpEnded end;
    end.slot = ends_.front();
    ended_->push(now, end);
    ends_.pop();
    domain_.request(now + ended_->latency());
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
  return resident() == 0 && lsu_.idle() && batches_.empty() && trace_calls_.empty() && any_hits_done_.empty() &&
         ends_.empty();
}

SimtCounters SimtCore::counters() const {
  SimtCounters counters = counters_;
  for (const Slot& slot : slots_) {
    if (slot.step == Step::free) continue;
    counters.warp_cycles[static_cast<std::size_t>(slot.activity)] += domain_.cycle() - slot.since;
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
  inventory.storage.push_back({"register_file", StorageKind::ram, config_.registers * 32, 3, 1, false, 32 * kMaxLanes});
  inventory.storage.push_back(
      {"warp_control", StorageKind::flip_flop, config_.resident_warps * kWarpControlBits, 1, 1, false});
  inventory.operators.push_back({"fp_fma", 32, lanes});
  inventory.operators.push_back({"int_add", 32, lanes});
  inventory.operators.push_back({"fp_compare", 32, lanes});
  return inventory;
}

void SimtCore::dump_state(std::ostream& out) const {
  out << name() << ": " << resident() << " warps resident, " << batches_.size() << " any-hit batches waiting, "
      << trace_calls_.size() << " trace calls waiting\n";
  for (unsigned slot = 0; slot < slots_.size(); ++slot) {
    const Slot& warp = slots_[slot];
    if (warp.step == Step::free) continue;
    out << "  slot " << slot << ": group " << program_.group(slot)->index << " round " << program_.round(slot) << " "
        << kStepNames[static_cast<std::size_t>(warp.step)] << (warp.in_any_hit ? " in any-hit" : "") << " since cycle "
        << warp.since << ", loads pending " << lsu_.loads_pending(slot) << ", stores pending "
        << lsu_.stores_pending(slot) << "\n";
  }
  lsu_.dump_state(out);
}

}  // namespace grtx::modules
