// Events that take no time. With a stride of n, one in n of a lane's events is simulated as always; the others happen
// at once, in between: they read and write the caches' tags and all state that later events depend on, but reserve
// nothing. So every warp meets the caches that it would meet, among as many others as always, and does a share of
// everything in that share of the time. Sampling with functional warming (SMARTS, Wunderlich et al., ISCA 2003), within
// each lane.
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeDefinition;
using traces::NodeKind;

void Machine::warm(Number number, Lane& lane, Sm& sm, Call& call, unsigned count) {
  const unsigned s = lane.sm;
  for (; count > 0 && lane.next != lane.end; --count) {
    const Event event = *lane.next++;
    const EventEffect effect(event);
    switch (event.kind()) {
      case EventKind::visit_internal:
      case EventKind::visit_instance:
      case EventKind::visit_leaf: {
        const NodeSectors sectors(visit(number, event, sm, call), traffic_);
        ++sm.rt.memory.visits[static_cast<std::size_t>(sectors.region())];
        sectors.for_each_run([&](const SectorRun& run, bool /*last*/) {
          if (!run.again) warm_run(s, sm, kNode, run);
        });
        move_stack(number, lane, effect, sm);
        if (records_) {
          const traces::RayGroup& group = *sm.warps[call.slot].group;
          if (event.kind() == EventKind::visit_internal) {
            records_->note(number, group, event.node, event.pushed());
          } else if (const Siblings siblings = records_->take(number, group, event.node); siblings.mask != 0) {
            warm_siblings(s, sm, group.nodes[siblings.definition], siblings.mask);
          }
        }
        if (effect.calls_any_hit()) warm_any_hit(s, sm, call, number, event);
        break;
      }
      case EventKind::cull:
        ++sm.rt.scheduler.culls;
        move_stack(number, lane, effect, sm);
        break;
      default:
        if (!header_.checkpoint) refuse(number, kRuleReplayNeedsCheckpoints);
        warm_source(s, sm, number);
        ++(event.kind() == EventKind::replay_take ? sm.rt.scheduler.replay_takes : sm.rt.scheduler.replay_forwards);
        move_stack(number, lane, effect, sm);
    }
    const unsigned checkpoints = effect.checkpoints();
    if (header_.checkpoint) {
      warm_checkpoints(s, sm, number, checkpoints, lane.next == lane.end);
    } else if (checkpoints != 0) {
      refuse(number, kRuleEntriesNeedCheckpoints);
    }
  }
}

// Of each `stride_` events of a lane one takes time. It is the last, unless an earlier one visits a node that its warp
// is fetching already: then that one does, and joins the fetch, and the rest follow with the next. Else lanes that are
// a little behind others would join them more seldom than they do, since each step takes them further.
bool Machine::warm_up_to_next(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, Cycle apart) {
  if (std::exchange(lane.begins, false)) return true;
  warm(number, lane, sm, call, std::exchange(lane.owed, std::uint16_t{0}));
  for (unsigned i = 0; i + 1 < stride_ && lane.next != lane.end; ++i) {
    if (is_under_way(*lane.next, sm, call, now, now + i * apart)) {
      lane.owed = static_cast<std::uint16_t>(stride_ - 1 - i);
      return true;
    }
    warm(number, lane, sm, call, 1);
  }
  return lane.next != lane.end;
}

// Not of a shared BLAS: its nodes are under way all the time, and lanes meet there that are not on one path.
bool Machine::is_under_way(const Event& event, const Sm& sm, const Call& call, Cycle now, Cycle then) const {
  if (!config_.rt.memory.merge_in_flight) return false;  // nobody joins
  const std::optional<NodeVisit> node = node_visit(event, *sm.warps[call.slot].group, traffic_);
  if (!node || traffic_.region(node->kind, node->address) == Region::blas) return false;
  const Fetches& fetches = call.fetches;
  for (std::uint32_t same = fetches.of_node(Fetches::key_of(node->address, node->header)); same != 0;
       same &= same - 1) {
    const auto leader = static_cast<unsigned>(std::countr_zero(same));
    if (fetches.lanes[leader] != 0 ? then == now : fetches.ready[leader].at(now) > then) return true;
  }
  return false;
}

void Machine::any_hit(Sm& sm, const AnyHitBatch& batch, AnyHitWork& counted) {
  const ShaderCounters& counters = sm.program.counters();
  const std::uint64_t loads = counters.load_instructions, stores = counters.store_instructions;
  sm.program.any_hit(batch, phase_);
  ++counted.batches;
  counted.loads += counters.load_instructions - loads;
  counted.stores += counters.store_instructions - stores;
}

void Machine::warm_any_hit(unsigned s, Sm& sm, const Call& call, Number number, const Event& event) {
  ++sm.rt.scheduler.any_hit_calls;
  AnyHitBatch batch;
  batch.slot = call.slot;
  batch.round = sm.program.round(call.slot);
  add_lane(batch, number % kMaxLanes, event);
  any_hit(sm, batch, sm.warming_any_hits);
  for (const SectorAccess& sector : phase_.loads) warm_line(s, sm, kSimt, sector, false);
  for (const SectorAccess& sector : phase_.stores) warm_line(s, sm, kSimt, sector, true);
}

// Siblings in one line are one access.
void Machine::warm_siblings(unsigned s, Sm& sm, const NodeDefinition& node, unsigned siblings) {
  std::uint64_t line = 0;
  std::uint8_t sectors = 0;
  Region region{};
  records_->for_each_child(node, siblings, [&](NodeKind kind, std::uint32_t child) {
    const std::uint64_t begin = std::uint64_t{child} * traces::kNodeUnit;
    region = traffic_.region(kind, begin);
    for_each_part(sm, begin, traffic_.sectors(kind), sm.sectors, [&](std::uint64_t at, std::uint8_t mask) {
      if (at != line && sectors != 0) warm_line(s, sm, kPrefetch, line, sectors, region, false);
      sectors = at == line ? static_cast<std::uint8_t>(sectors | mask) : mask;
      line = at;
    });
  });
  if (sectors != 0) warm_line(s, sm, kPrefetch, line, sectors, region, false);
}

void Machine::warm_run(unsigned s, Sm& sm, Client client, const SectorRun& run) {
  for_each_part(sm, run.address, run.sectors, sm.sectors, [&](std::uint64_t line, std::uint8_t mask) {
    warm_line(s, sm, client, line, mask, run.region, false);
  });
}

// What a prefetch brings in here has no mark: the marks are counted.
void Machine::warm_caches(unsigned s, Sm& sm, Client client, std::uint64_t line, std::uint8_t sectors, Region region,
                          bool write) {
  if (config_.l1.perfect) return;
  const SectorCacheTags::Slot slot = sm.tags.find(line);
  std::uint8_t missing = sectors;
  if (slot != SectorCacheTags::kNone) {
    sm.tags.touch(slot);
    const auto present = static_cast<std::uint8_t>(sectors & sm.tags.valid(slot));
    if (client != kPrefetch) demand(sm, slot, present);
    if (!write) missing ^= present;
  }
  if (missing == 0) return;
  if (!write) {
    if (const std::uint32_t filling = sm.filling.find(line / kSectorBytes); filling != AddressIndex::kNone) {
      Fill& fill = sm.fills[filling];
      const auto on_the_way = static_cast<std::uint8_t>(missing & fill.sectors);
      if (client != kPrefetch) demand(sm, fill, on_the_way, on_the_way);
      missing ^= on_the_way;
      if (missing == 0) return;
    }
  }
  memory_.warm({s, line, missing, region, write});
  if (!write) place(sm, line, missing, false);
}

}  // namespace grtx::sim::fast
