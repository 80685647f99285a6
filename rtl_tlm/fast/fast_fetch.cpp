// Node fetches of the RT unit in fast mode: merging within a warp, and the siblings that are prefetched.
#include <algorithm>
#include <bit>

#include "rtl_tlm/fast/fast_machine.h"

namespace grtx::tlm::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeDefinition;
using traces::NodeKind;

void Machine::fetch(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, NodeKind kind, std::uint64_t address,
                    bool header) {
  MemoryScheduler::Counters& counters = sm.rt.memory;
  const Region region = traffic_.region(kind, address);
  ++counters.visits[static_cast<std::size_t>(region)];
  if (lane.next + 1 != lane.end && lane.next[1].kind() == EventKind::visit_internal) {
    prefetch_for_read(sm.warps[call.slot].group->nodes.data() + lane.next[1].node);
  }
  // A visit joins a fetch of its warp that is under way, or without merging in flight one that begins in this cycle.
  Fetches& fetches = call.fetches;
  const std::uint32_t key = Fetches::key_of(address, header);
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
  ++counters.fetches[static_cast<std::size_t>(region)];
  ++sm.fetches;
  if (traffic_.descriptor_read() && kind != NodeKind::internal && kind != NodeKind::instance) {
    push_node(sm, kNode, number, address, 1, region, false);
  }
  push_node(sm, kNode, number, address, traffic_.sectors(kind), region, !header);
  if (header) {
    const auto sectors = static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes);
    push_node(sm, kNode, number, traffic_.blas_header(), sectors, Region::blas, true);
  }
}

void Machine::push_node(Sm& sm, Client client, Number owner, std::uint64_t address, unsigned sectors, Region region,
                        bool last) {
  RingQueue<Request>& queue = sm.ports[client].queue;
  sm.waiting |= 1u << client;
  if (client == kNode) {
    sm.rt.memory.sectors[static_cast<std::size_t>(region)] += sectors;
  } else {
    sm.rt.prefetch.sectors += sectors;
    sm.rt.prefetch.responses += sectors;
  }
  for (;;) {
    const std::uint64_t line = sm.tags.line_address(address);
    const auto first = static_cast<unsigned>((address - line) / kSectorBytes);
    const unsigned count = std::min({sectors, sm.sectors - first, sm.largest});
    const auto mask = static_cast<std::uint8_t>(((1u << count) - 1) << first);
    sectors -= count;
    queue.push({line, owner, mask, region, false, last && sectors == 0});
    if (sectors == 0) return;
    address += std::uint64_t{count} * kSectorBytes;
  }
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

void Machine::note_internal(Number number, const Lane& lane, const Event& event) {
  const NodeDefinition& node = group_of(lane).nodes[event.node];
  bool has_leaf = false;
  std::uint32_t end = node.child_base;
  for (unsigned i = 0; i < node.child_count; ++i) {
    end += units_[static_cast<std::size_t>(node.child_kinds[i])];
    has_leaf = has_leaf || ((event.pushed() >> i & 1) != 0 && node.child_kinds[i] != NodeKind::internal);
  }
  if (!has_leaf) return;
  std::uint8_t& newest = newest_[number];
  newest = newest + 1u == config_.rt.prefetcher.records ? std::uint8_t{0} : static_cast<std::uint8_t>(newest + 1);
  records_of(number)[newest] = {node.child_base, end, event.node, static_cast<std::uint8_t>(event.pushed()), true};
}

// As SiblingPrefetcher: the first of the hit children that is asked for brings the others.
void Machine::note_leaf(Cycle now, Number number, const Lane& lane, Sm& sm, std::uint32_t address) {
  Record* const records = records_of(number);
  unsigned at = newest_[number];
  for (unsigned back = 0; back < config_.rt.prefetcher.records; ++back) {
    Record& record = records[at];
    at = at == 0 ? config_.rt.prefetcher.records - 1 : at - 1;
    if (record.hit == 0) return;
    if (address < record.begin || address >= record.end) continue;
    if (!record.armed) return;
    record.armed = false;
    const NodeDefinition& node = group_of(lane).nodes[record.definition];
    ++sm.rt.prefetch.triggers;
    unsigned t = 0;
    while (t < triggered_count_ && triggered_[t].definition != record.definition) ++t;
    if (t == triggered_count_) triggered_[triggered_count_++] = {record.definition, 0};
    unsigned siblings = 0;
    const bool idle = sm.ports[kPrefetch].queue.empty();
    std::uint32_t child = node.child_base;
    for (unsigned i = 0; i < node.child_count; ++i) {
      const NodeKind kind = node.child_kinds[i];
      if ((record.hit >> i & 1) != 0 && child != address) {
        siblings |= 1u << i;
        if ((triggered_[t].asked >> i & 1) != 0) {
          ++sm.rt.prefetch.merged;
        } else {
          prefetch(sm, kind, std::uint64_t{child} * traces::kNodeUnit);
        }
      }
      child += units_[static_cast<std::size_t>(kind)];
    }
    triggered_[t].asked = static_cast<std::uint8_t>(triggered_[t].asked | siblings);
    if (idle) serve(now, lane.sm);
    return;
  }
}

void Machine::prefetch(Sm& sm, NodeKind kind, std::uint64_t address) {
  RingQueue<Request>& queue = sm.ports[kPrefetch].queue;
  const std::uint64_t line = sm.tags.line_address(address);
  const std::uint8_t first = sm.tags.sector_bit(address);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    if (queue[i].line == line && (queue[i].sectors & first) != 0) {
      ++sm.rt.prefetch.merged;
      return;
    }
  }
  if (queue.size() >= config_.rt.prefetcher.queue) {
    ++sm.rt.prefetch.dropped;
    return;
  }
  ++sm.rt.prefetch.nodes;
  push_node(sm, kPrefetch, 0, address, traffic_.sectors(kind), traffic_.region(kind, address), true);
}

}  // namespace grtx::tlm::fast
