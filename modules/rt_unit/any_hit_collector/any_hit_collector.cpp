// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_collector.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <ostream>
#include <string>

#include "grtx/modules/rt_unit/decide/event_effect.h"

namespace grtx::modules {

const CounterTable<AnyHitCounters>& AnyHitCounters::table() {
  using C = AnyHitCounters;
  using U = AnyHitUnitCounters;
  const auto of_unit = [](auto field) {
    return [field](auto& c) -> auto& { return c.unit.*field; };
  };
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::batches, "batches", "batches", "any-hit shader invocations")
          .sum(&C::lanes, "lanes", "lanes", "any-hit calls of lanes, in all batches")
          .mean({"lanes", &C::lanes}, {"batches", &C::batches}, "lanes_per_batch", "lanes", "mean lanes of a batch")
          .sum(&C::timeouts, "timeouts", "batches", "batches sent before all active lanes had a hit")
          .sum(&C::wait_cycles, "wait_cycles", "cycles", "first waiting lane to invocation, summed over batches")
          .sum(of_unit(&U::answers))
          .when([](const C& c) { return c.unit.hits != 0; })
          .sum(of_unit(&U::hits), "unit.hits", "hits", "hits that the any-hit unit handled")
          .sum(of_unit(&U::entered), "unit.entered", "hits", "of these, hits that entered a heap")
          .sum(of_unit(&U::busy_cycles), "unit.busy_cycles", "cycles", "busy heap logic, summed over cycles")
          .sum(of_unit(&U::wait_cycles), "unit.wait_cycles", "cycles", "cycles that hits waited for their heap logic")
          .when([](const C& c) { return c.unit.bounded != 0; })
          .sum(of_unit(&U::bounded), "unit.bounded", "hits", "with opacity_bound: hits whose opacity was added")
          .sum(of_unit(&U::hidden), "unit.hidden", "hits", "with opacity_bound: entries that left heaps as hidden");
  return table;
}

AnyHitCollector::AnyHitCollector(const sc_core::sc_module_name& name, const Config& config, unsigned entries,
                                 bool names_instances)
    : AnyHitModule(name),
      config_(config),
      firing_(config.timeout),
      entries_(entries),
      names_instances_(names_instances) {
  awake_ = false;
}

void AnyHitCollector::end_of_elaboration() {
  buffer_ = &warp_buffer->warps();
  client_ = client.operator->();
  batches_ = writer_of(batch);
  dones_ = reader_of(done);
}

void AnyHitCollector::arrive(Cycle now, LaneId id) {
  const unsigned entry = entry_of(id);
  Warp& warp = buffer_->warp(entry);
  if (warp.in_state(LaneState::waiting_any_hit) == 0) {
    warp.any_hit_since = now;
    if (warp.in_state(LaneState::in_any_hit) == 0) become_candidate(entry);
  }
  buffer_->move(entry, bit(lane_of(id)), LaneState::in_unit, LaneState::waiting_any_hit);
}

void AnyHitCollector::finished(unsigned entry) {
  if (buffer_->warp(entry).in_state(LaneState::waiting_any_hit) != 0) become_candidate(entry);
}

void AnyHitCollector::invoke(Cycle now) {
  if (const AnyHitDone* answer = dones_.front(now)) {
    client_->any_hit_done(now, *answer);
    dones_.pop(now);
  }
  if (candidates_ != 0) fire_oldest(now);
}

void AnyHitCollector::fire_oldest(Cycle now) {
  const std::optional<unsigned> fires = firing_.next(*buffer_, candidates_, now);
  if (!fires || !batches_.can_push(now)) return;
  const unsigned entry = *fires;
  const Warp& warp = buffer_->warp(entry);
  AnyHitBatch message;
  message.slot = warp.slot;
  message.round = warp.round;
  for_each_bit(warp.in_state(LaneState::waiting_any_hit),
               [&](unsigned i) { add_lane(message, i, warp.lane[i].event); });
  if (names_instances_) {
    for_each_bit(message.lanes,
                 [&](unsigned i) { message.leaf[i] = instance_above(warp.lane[i].next, warp.group->rays[i]); });
  }
  ++counters_.batches;
  counters_.lanes += static_cast<unsigned>(std::popcount(message.lanes));
  if (message.lanes != warp.active()) ++counters_.timeouts;
  counters_.wait_cycles += now - warp.any_hit_since;
  batches_.push(now, message);
  buffer_->move(entry, message.lanes, LaneState::waiting_any_hit, LaneState::in_any_hit);
  candidates_ &= ~bit(entry);
  awake_ = candidates_ != 0;
}

std::uint64_t AnyHitCollector::lanes_in(LaneState state) const {
  std::uint64_t lanes = 0;
  for_each_bit(buffer_->occupied(), [&](unsigned entry) {
    lanes += static_cast<unsigned>(std::popcount(buffer_->warp(entry).in_state(state)));
  });
  return lanes;
}

Cycle AnyHitCollector::longest_wait(Cycle now) const {
  Cycle longest = 0;
  for_each_bit(buffer_->occupied(), [&](unsigned entry) {
    const Warp& warp = buffer_->warp(entry);
    if (warp.in_state(LaneState::waiting_any_hit) != 0) longest = std::max(longest, now - warp.any_hit_since);
  });
  return longest;
}

std::vector<UnitProbe> AnyHitCollector::probes() const {
  const auto width = static_cast<unsigned>(std::bit_width(entries_ * kMaxLanes));
  return {{"lanes_waiting", width, [this] { return lanes_in(LaneState::waiting_any_hit); }},
          {"lanes_at_shader", width, [this] { return lanes_in(LaneState::in_any_hit); }},
          {"timer",
           kLevelBits,
           {},
           [this](Cycle now) { return std::min<Cycle>(longest_wait(now), (1u << kLevelBits) - 1); }},
          {"batches", kCounterBits, [this] { return counters_.batches; }},
          {"timeouts", kCounterBits, [this] { return counters_.timeouts; }}};
}

Inventory AnyHitCollector::inventory() const {
  Inventory inventory{name(), {}, {}};
  unsigned bits = 1;
  while (bits < 32 && (config_.timeout >> bits) != 0) ++bits;
  inventory.storage.push_back({"timers", StorageKind::flip_flop, std::uint64_t{entries_} * bits});
  inventory.operators.push_back({"int_compare", bits, entries_});
  return inventory;
}

void AnyHitCollector::dump_state(std::ostream& out) const {
  for_each_bit(candidates_, [&](unsigned e) {
    const Warp& warp = buffer_->warp(e);
    out << name() << ": entry " << e << " has " << std::popcount(warp.in_state(LaneState::waiting_any_hit))
        << " lanes waiting since cycle " << warp.any_hit_since << '\n';
  });
}

PartInfo part_info(const AnyHitCollectorConfig&) {
  PartInfo part;
  part.name = "any_hit_collector";
  part.title = "any-hit collector";
  part.statistics = {"gpu.rt.any_hit"};
  part.keys = {"rt.any_hit"};
  part.stalls = {{"any_hit", "any-hit shaders"}};
  return part;
}

}  // namespace grtx::modules
