// Node fetches of the RT unit in fast mode: merging within a warp, and the siblings that are prefetched.
#include <algorithm>
#include <bit>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;

NodeVisit Machine::visit(Number number, const Event& event, Sm& sm, const Call& call) {
  const std::optional<NodeVisit> node = node_visit(event, *sm.warps[call.slot].group, traffic_);
  if (!node) refuse(number, rule_of_missing_node(event));
  RtScheduler::Counters& counters = sm.rt.scheduler;
  switch (event.kind()) {
    case EventKind::visit_internal:
      ++counters.visits_internal;
      break;
    case EventKind::visit_instance:
      ++counters.visits_instance;
      break;
    default:
      ++counters.visits_leaf;
  }
  return *node;
}

void Machine::fetch(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, const NodeVisit& node) {
  MemoryScheduler::Counters& counters = sm.rt.memory;
  const NodeSectors sectors(node, traffic_);
  const auto region = static_cast<std::size_t>(sectors.region());
  ++counters.visits[region];
  if (lane.end - lane.next > static_cast<std::ptrdiff_t>(stride_) &&
      lane.next[stride_].kind() == EventKind::visit_internal) {
    prefetch_for_read(sm.warps[call.slot].group->nodes.data() + lane.next[stride_].node);
  }
  // A visit joins a fetch of its warp that is under way, or without merging in flight one that begins in this cycle.
  Fetches& fetches = call.fetches;
  const std::uint32_t key = Fetches::key_of(node.address, node.header);
  for (std::uint32_t same = fetches.of_node(key); same != 0; same &= same - 1) {
    const auto leader = static_cast<unsigned>(std::countr_zero(same));
    const bool asked_for = fetches.lanes[leader] == 0;
    const Cycle ready = fetches.ready[leader].at(now);
    if (config_.rt.memory.merge_in_flight ? asked_for && ready <= now : fetches.asked[leader].at(now) != now) continue;
    if (asked_for) return await(sm, number, lane, ready);
    fetches.lanes[leader] |= static_cast<std::uint32_t>(lane_bit(number));
    return;
  }
  const unsigned leader = number % kMaxLanes;
  fetches.key[leader] = key;
  fetches.asked[leader] = fetches.ready[leader] = NearCycle(now);
  fetches.lanes[leader] = static_cast<std::uint32_t>(lane_bit(number));
  ++counters.fetches[region];
  ++sm.fetches;
  sectors.for_each_run([&](const SectorRun& run, bool last) { push_run(sm, kNode, number, run, last); });
}

void Machine::push_run(Sm& sm, Client client, Number owner, const SectorRun& run, bool last) {
  RingQueue<Request>& queue = sm.ports[client].queue;
  sm.waiting |= 1u << client;
  unsigned sectors = run.sectors;
  if (client == kNode) {
    sm.rt.memory.sectors[static_cast<std::size_t>(run.region)] += sectors;
  } else {
    sm.rt.prefetch.sectors += sectors;
    sm.rt.prefetch.responses += sectors;
  }
  for_each_part(sm, run.address, sectors, sm.largest, [&](std::uint64_t line, std::uint8_t mask) {
    sectors -= static_cast<unsigned>(std::popcount(mask));
    queue.push({line, owner, mask, run.region, false, last && sectors == 0});
  });
}

void Machine::await(Sm& sm, Number number, const Lane& lane, Cycle ready) {
  const Event event = *lane.next;
  unsigned tests = 1;
  Unit* unit = &sm.leaf;
  if (event.kind() == EventKind::visit_internal) {
    unit = &sm.box;
    if (config_.rt.box_op_per_child) tests = std::max(1u, unsigned{group_of(lane).nodes[event.node].child_count});
  } else if (event.kind() == EventKind::visit_instance) {
    unit = &sm.transform;
  }
  wheel_.add(unit->test(ready, tests) - 1, number);  // its warp can be selected in the cycle after it
}

void Machine::prefetch_siblings(Cycle now, const Lane& lane, Sm& sm, const Siblings& siblings) {
  ++sm.rt.prefetch.triggers;
  const bool idle = sm.ports[kPrefetch].queue.empty();
  const unsigned fresh = requests_.fresh(siblings);
  sm.rt.prefetch.merged += static_cast<unsigned>(std::popcount(siblings.mask & ~fresh));
  records_->for_each_child(group_of(lane).nodes[siblings.definition], fresh, [&](NodeKind kind, std::uint32_t child) {
    prefetch(sm, kind, std::uint64_t{child} * traces::kNodeUnit);
  });
  if (idle) serve(now, lane.sm);
}

void Machine::prefetch(Sm& sm, NodeKind kind, std::uint64_t address) {
  RingQueue<Request>& queue = sm.ports[kPrefetch].queue;
  const std::uint64_t line = sm.tags.line_address(address);
  const std::uint8_t first = sm.tags.sector_bit(address);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    if (queue[i].line == line && (queue[i].sectors & first) != 0 && queue[i].owner != kNobody) {
      ++sm.rt.prefetch.merged;
      return;
    }
  }
  if (sm.ports[kPrefetch].timed() >= config_.rt.prefetcher.queue) {
    ++sm.rt.prefetch.dropped;
    return;
  }
  ++sm.rt.prefetch.nodes;
  push_run(sm, kPrefetch, 0, {address, traffic_.sectors(kind), traffic_.region(kind, address)}, true);
}

}  // namespace grtx::sim::fast
