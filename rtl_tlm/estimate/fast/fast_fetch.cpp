// Node fetches of the RT unit in fast mode: merging within a warp, and the tests when a node has come.
#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;

NodeVisit RtUnit::visit(LaneId id, const Event& event, const Call& call) {
  const std::optional<NodeVisit> node = node_visit(event, *call.group, shared_.traffic);
  if (!node) refuse(id, rule_of_missing_node(event));
  RtScheduler::Counters& counters = counters_.scheduler;
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

void RtUnit::fetch(Cycle now, LaneId id, Lane& lane, Call& call, const NodeVisit& node) {
  MemoryScheduler::Counters& counters = counters_.memory;
  const NodeSectors sectors(node, shared_.traffic);
  const auto region = static_cast<std::size_t>(sectors.region());
  ++counters.visits[region];
  const unsigned stride = shared_.stride;
  if (lane.end - lane.next > static_cast<std::ptrdiff_t>(stride) &&
      lane.next[stride].kind() == EventKind::visit_internal) {
    prefetch_for_read(call.group->nodes.data() + lane.next[stride].node);
  }
  // A visit joins a fetch of its warp that is under way, or without merging in flight one that begins in this cycle.
  NodeFetches& fetches = call.fetches;
  const std::uint32_t key = NodeFetches::key_of(node);
  for (std::uint32_t same = fetches.of_node(key); same != 0; same &= same - 1) {
    const auto leader = static_cast<unsigned>(std::countr_zero(same));
    const bool asked_for = fetches.lanes[leader] == 0;
    const Cycle ready = fetches.ready[leader].at(now);
    if (config_.memory.merge_in_flight ? asked_for && ready <= now : fetches.asked[leader].at(now) != now) continue;
    if (asked_for) return await(id, lane, call, ready);
    fetches.lanes[leader] |= static_cast<std::uint32_t>(lane_bit(id));
    return;
  }
  const unsigned leader = lane_of(id);
  fetches.key[leader] = key;
  fetches.asked[leader] = fetches.ready[leader] = NearCycle(now);
  fetches.lanes[leader] = static_cast<std::uint32_t>(lane_bit(id));
  ++counters.fetches[region];
  ++fetches_;
  sectors.for_each_run([&](const SectorRun& run, bool last) {
    counters.sectors[static_cast<std::size_t>(run.region)] += run.sectors;
    l1_.push(kNode, id, run, false, last);
  });
}

void RtUnit::node_arrives(std::uint32_t leader, Cycle seen, bool last, Cycle pushed) {
  const unsigned entry = entry_of(static_cast<LaneId>(leader)), lane = lane_of(static_cast<LaneId>(leader));
  Call& call = calls_[entry];
  NodeFetches& fetches = call.fetches;
  const Cycle ready = std::max(fetches.ready[lane].at(seen), seen);
  fetches.ready[lane] = NearCycle(ready);
  if (!last) return;
  --fetches_;
  leaving_.push(pushed);
  counters_.memory.fetch_latency.add(ready - fetches.asked[lane].at(ready));
  for_each_bit(std::exchange(fetches.lanes[lane], 0u), [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    await(id, lanes_[id], call, ready);
  });
}

void RtUnit::await(LaneId id, const Lane& lane, const Call& call, Cycle ready) {
  const Event event = *lane.next;
  unsigned tests = 1;
  IntersectionPipelines* unit = &leaf_;
  if (boxes_ && event.kind() == EventKind::visit_leaf) return shared_.agenda.add(ready, {What::lane, sm_, id});
  if (event.kind() == EventKind::visit_leaf) tests = shared_.traffic.leaf_tests();
  if (event.kind() == EventKind::visit_internal) {
    unit = &box_;
    if (config_.box_op_per_child) tests = std::max(1u, unsigned{call.group->nodes[event.node].child_count});
  } else if (event.kind() == EventKind::visit_instance) {
    unit = &transform_;
  }
  if (transforms_leaves_ && event.kind() == EventKind::visit_leaf) ready = transform_.test(ready, 1);
  // Its warp can be selected in the cycle after it.
  shared_.agenda.add(unit->test(ready, tests) - 1, {What::lane, sm_, id});
}

}  // namespace grtx::sim::fast
