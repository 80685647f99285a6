// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"

#include <algorithm>
#include <ostream>

#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::modules {

using traces::LeafOutcome;

AnyHitUnit::AnyHitUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries, unsigned k,
                       bool evicts)
    : AnyHitModule(name),
      config_(config),
      k_(k),
      evicts_(evicts),
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

Cycle AnyHitUnit::take(LaneId id, LeafOutcome outcome) {
  ++counters_.unit.hits;
  switch (outcome) {
    case LeafOutcome::inserted:
      fill_[id] = std::min(fill_[id] + 1, k_);
      ++counters_.unit.entered;
      return config_.insertion(fill_[id]);
    case LeafOutcome::displaced:
      ++counters_.unit.entered;
      return config_.displacement(k_);
    default:
      return config_.latency;
  }
}

void AnyHitUnit::arrive(Cycle now, LaneId id) {
  Warp& warp = warps_->warp(entry_of(id));
  const LeafOutcome outcome = warp.lane[lane_of(id)].event.outcome();
  Cycle& free_from = free_from_[lane_of(id) % config_.count];
  const Cycle begin = std::max(now, free_from);
  const Cycle busy = take(id, outcome);
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
  return inventory;
}

void AnyHitUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << flights_.size() << " hits in heaps, " << evicting_.size() << " to be stored\n";
}

// An entry of a heap is three of the 32 words that an access of the register file moves. A step, read, comparison and
// write, takes two cycles.
PartInfo part_info(const AnyHitUnitConfig&) {
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
                  .off_by_default = true}};
  return part;
}

}  // namespace grtx::modules
