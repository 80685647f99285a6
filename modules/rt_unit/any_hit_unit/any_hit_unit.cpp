// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"

#include <algorithm>
#include <ostream>

#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::modules {

using traces::LeafOutcome;

namespace {

constexpr unsigned kOpacityBits = 16;  // a factor of 2^64

}  // namespace

AnyHitUnit::AnyHitUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries, unsigned k,
                       bool evicts, bool bounded)
    : AnyHitModule(name),
      config_(config),
      k_(k),
      evicts_(evicts),
      bounded_(bounded),
      fill_(std::size_t{entries} * kMaxLanes),
      free_from_(config.count) {
  require_allowed("rt.any_hit_unit", config);
}

void AnyHitUnit::end_of_elaboration() {
  warps_ = &warp_buffer->warps();
  client_ = client.operator->();
  batches_ = writer_of(batch);
}

void AnyHitUnit::restart() {
  std::fill(fill_.begin(), fill_.end(), 0);
  std::fill(free_from_.begin(), free_from_.end(), 0);
  flights_ = {};
  evicting_.clear();
  order_ = 0;
  counters_ = {};
}

bool AnyHitUnit::evicts(LeafOutcome outcome) const { return evicts_ && traces::evicts(outcome); }

Cycle AnyHitUnit::take(LaneId id, const traces::Event& event) {
  ++counters_.unit.hits;
  Cycle cycles = config_.latency;
  if (event.outcome() == LeafOutcome::inserted) {
    ++fill_[id];
    cycles = config_.insertion(entries_of(id));
  } else if (event.outcome() == LeafOutcome::displaced) {
    cycles = config_.displacement(k_);
  } else {
    return cycles;
  }
  ++counters_.unit.entered;
  return bounded_ ? cycles + hide(id, event.hidden()) : cycles;
}

// The opacity of the hit is added to that of its heap. While what is left ends the ray without the root, the root
// leaves and the last entry sinks from its place.
Cycle AnyHitUnit::hide(LaneId id, unsigned hidden) {
  ++counters_.unit.bounded;
  counters_.unit.hidden += hidden;
  Cycle cycles = config_.bound_latency;
  for (unsigned i = 0; i < hidden; ++i, --fill_[id]) cycles += config_.displacement(entries_of(id));
  return cycles;
}

void AnyHitUnit::arrive(Cycle now, LaneId id) {
  Warp& warp = warps_->warp(entry_of(id));
  Cycle& free_from = free_from_[lane_of(id) % config_.count];
  const Cycle begin = std::max(now, free_from);
  const Cycle busy = take(id, warp.lane[lane_of(id)].event);
  free_from = begin + busy;
  counters_.unit.busy_cycles += busy;
  counters_.unit.wait_cycles += begin - now;
  flights_.push({free_from, order_++, id});
  warps_->move(entry_of(id), bit(lane_of(id)), LaneState::in_unit, LaneState::in_any_hit);
}

void AnyHitUnit::answer(Cycle now, LaneId id) {
  ++counters_.unit.answers;
  client_->any_hit_done(now, {warps_->warp(entry_of(id)).slot, bit(lane_of(id))});
}

void AnyHitUnit::invoke(Cycle now) {
  for (; !flights_.empty() && flights_.top().due <= now; flights_.pop()) {
    const LaneId id = flights_.top().lane;
    if (evicts(warps_->lane(id).event.outcome())) {
      evicting_.push(id);
    } else {
      answer(now, id);
    }
  }
  if (evicting_.empty() || !batches_.can_push(now)) return;
  const LaneId id = evicting_.front();
  evicting_.pop();
  const Warp& warp = warps_->warp(entry_of(id));
  AnyHitBatch fallen_out;
  fallen_out.slot = warp.slot;
  fallen_out.round = warp.round;
  add_lane(fallen_out, lane_of(id), warp.lane[lane_of(id)].event);
  batches_.push(now, fallen_out);
  answer(now, id);
}

Cycle AnyHitUnit::next_due(Cycle now) const {
  if (!evicting_.empty()) return now + 1;
  return flights_.empty() ? kNever : std::max(flights_.top().due, now + 1);
}

std::vector<UnitProbe> AnyHitUnit::probes() const {
  return {{"hits_held", static_cast<unsigned>(std::bit_width(fill_.size())), [this] { return held(); }},
          {"hits", kCounterBits, [this] { return counters_.unit.hits; }, {}, true},
          {"entered", kCounterBits, [this] { return counters_.unit.entered; }, {}, true}};
}

Inventory AnyHitUnit::inventory() const {
  // The heaps themselves are registers of the threads: simt.payload_registers.
  Inventory inventory{name(), {}, {}};
  constexpr unsigned kFillBits = 8;
  const std::uint64_t lanes = fill_.size();
  inventory.storage.push_back({"fill", StorageKind::ram, lanes * kFillBits, 1, 1, false, kFillBits});
  // Queue of hits that wait for their heap: number of the warp, t, alpha, id.
  inventory.storage.push_back(
      {"hits", StorageKind::ram, lanes * (8 + 32 * HitHeap::kEntryWords), 1, 1, false, 8 + 32 * HitHeap::kEntryWords});
  // Each heap logic holds the moving entry and one beside it, compares t and then id, and computes an index.
  inventory.storage.push_back(
      {"moving", StorageKind::flip_flop, std::uint64_t{config_.count} * 2 * 32 * HitHeap::kEntryWords});
  inventory.operators.push_back({"fp_compare", 32, config_.count});
  inventory.operators.push_back({"int_compare", 32, config_.count});
  inventory.operators.push_back({"int_add", 8, config_.count});
  // The lanes of a heap logic have rows of the register file of their own: to read and to write, a decoder for each
  // logic beyond the first, two gates a row.
  constexpr std::uint64_t kRegisterRows = 2048;  // 65,536 registers of threads, 32 to a row
  inventory.operators.push_back({"mux", 1, 2 * kRegisterRows * (config_.count - 1)});
  if (!bounded_) return inventory;
  // For each lane the sum of its heap's opacities and that at which its ray ends.
  inventory.storage.push_back({"opacity", StorageKind::ram, lanes * 2 * kOpacityBits, 1, 1, false, 2 * kOpacityBits});
  // For each heap logic 1 - alpha, a table of 256 constants of 10 bits (a multiplexer of two constants is a wire), an
  // adder for the sum, one for the sum without the root, and a comparator.
  inventory.operators.push_back({"fp_add", 32, config_.count});
  inventory.operators.push_back({"mux", 10, 127 * std::uint64_t{config_.count}});
  inventory.operators.push_back({"int_add", kOpacityBits, 2 * std::uint64_t{config_.count}});
  inventory.operators.push_back({"int_compare", kOpacityBits, config_.count});
  return inventory;
}

void AnyHitUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << flights_.size() << " hits in heaps, " << evicting_.size() << " to be stored\n";
}

// An entry of a heap is three of the 32 words that an access of the register file moves. A step, read, comparison and
// write, takes two cycles.
PartInfo part_info(const AnyHitUnitConfig& config) {
  constexpr double kOfARow = static_cast<double>(HitHeap::kEntryWords) / kMaxLanes;
  PartInfo part;
  part.name = "any_hit_unit";
  part.title = "any-hit unit";
  part.statistics = {"gpu.rt.any_hit.unit."};
  part.keys = {"rt.any_hit_unit."};
  part.energy = {{.name = "rt.any_hit_unit",
                  .statistics = {"gpu.rt.any_hit.unit.busy_cycles", "gpu.simt.heap_cycles"},
                  .factor = 0.5,
                  .terms = {uses("fp_compare", 32), reads("simt", "register_file", kOfARow),
                            writes("simt", "register_file", kOfARow)},
                  .basis = "steps of heaps: an entry read, compared and written",
                  .off_by_default = true},
                 {.name = "rt.any_hit_unit.bound",
                  .statistics = {"gpu.rt.any_hit.unit.bounded", "gpu.rt.any_hit.unit.hidden"},
                  .terms = {uses("fp_add", 32), uses("mux", 10, 127), uses("int_add", kOpacityBits, 2),
                            uses("int_compare", kOpacityBits), reads("any_hit_unit", "opacity"),
                            writes("any_hit_unit", "opacity")},
                  .basis = "opacities of hits that enter heaps or leave them because of it",
                  .off_by_default = true}};
  part.bounds = {{.name = "unit.heap",
                  .statistics = {"gpu.rt.any_hit.unit.busy_cycles"},
                  .rate = config.count,
                  .description = "busiest any-hit unit: cycles of its hits over its heap logics",
                  .words = "the heap logics of the any-hit units"}};
  return part;
}

}  // namespace grtx::modules
