// Node fetches of the RT unit in fast mode: merging within a warp, and the siblings that are prefetched.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeDefinition;
using traces::NodeKind;

namespace {

/// The kinds of a node's children, all at once.
class ChildKinds {
 public:
  explicit ChildKinds(const NodeDefinition& node) {
    static_assert(sizeof(node.child_kinds) == sizeof(bytes_));
    std::memcpy(&bytes_, node.child_kinds.data(), sizeof(bytes_));
  }
  /// Mask of slots whose child is no internal node.
  unsigned leaves() const { return ~mask_of(NodeKind::internal) & 0xFF; }
  /// Sum over the first `children` of what a child of its kind takes; those behind them are internal.
  std::uint32_t total(const std::array<std::uint32_t, 8>& of_kind, unsigned children) const {
    std::uint32_t sum = 0;
    unsigned internal = children;
    for (const NodeKind kind : {NodeKind::instance, NodeKind::procedural, NodeKind::triangle}) {
      const auto count = static_cast<unsigned>(std::popcount(mask_of(kind)));
      internal -= count;
      sum += count * of_kind[static_cast<std::size_t>(kind)];
    }
    return sum + internal * of_kind[static_cast<std::size_t>(NodeKind::internal)];
  }

 private:
  // Kinds are below 128: adding 127 to a byte that is not zero sets its highest bit.
  unsigned mask_of(NodeKind kind) const {
    constexpr std::uint64_t kOnes = 0x0101010101010101u;
    const std::uint64_t differs = bytes_ ^ kOnes * static_cast<std::uint64_t>(kind);
    const std::uint64_t equal = ~(differs + kOnes * 127) >> 7 & kOnes;
    return static_cast<unsigned>(equal * 0x0102040810204080u >> 56);
  }
  std::uint64_t bytes_ = 0;
};

}  // namespace

std::optional<Machine::Target> Machine::target_of(const Event& event, const Sm& sm, const Call& call) const {
  switch (event.kind()) {
    case EventKind::visit_internal: {
      const auto& nodes = sm.warps[call.slot].group->nodes;
      if (event.node >= nodes.size()) return std::nullopt;
      return Target{NodeKind::internal, std::uint64_t{nodes[event.node].address} * traces::kNodeUnit, false};
    }
    case EventKind::visit_instance:
      if (!traffic_.two_level()) return std::nullopt;
      return Target{NodeKind::instance, std::uint64_t{event.node} * traces::kNodeUnit,
                    event.detail == 0 && traffic_.header_read()};
    case EventKind::visit_leaf:
      return Target{traffic_.leaf_kind(), std::uint64_t{event.node} * traces::kNodeUnit, false};
    default:
      return std::nullopt;
  }
}

Machine::Target Machine::visit(Number number, const Event& event, Sm& sm, const Call& call) {
  const std::optional<Target> target = target_of(event, sm, call);
  if (!target) {
    refuse(number, event.kind() == EventKind::visit_internal ? "visits an internal node that the group does not define"
                                                             : "visits an instance leaf of a monolithic structure");
  }
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
  return *target;
}

void Machine::fetch(Cycle now, Number number, Lane& lane, Sm& sm, Call& call, const Target& target) {
  const auto& [kind, address, header] = target;
  MemoryScheduler::Counters& counters = sm.rt.memory;
  const Region region = traffic_.region(kind, address);
  ++counters.visits[static_cast<std::size_t>(region)];
  if (lane.end - lane.next > static_cast<std::ptrdiff_t>(stride_) &&
      lane.next[stride_].kind() == EventKind::visit_internal) {
    prefetch_for_read(sm.warps[call.slot].group->nodes.data() + lane.next[stride_].node);
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
  for_each_part(sm, address, sectors, sm.largest, [&](std::uint64_t line, std::uint8_t mask) {
    sectors -= static_cast<unsigned>(std::popcount(mask));
    queue.push({line, owner, mask, region, false, last && sectors == 0});
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

void Machine::note_internal(Number number, const Lane& lane, const Event& event) {
  const NodeDefinition& node = group_of(lane).nodes[event.node];
  const ChildKinds kinds(node);
  if ((kinds.leaves() & event.pushed()) == 0) return;
  const std::uint32_t end = node.child_base + kinds.total(units_, node.child_count);
  std::uint8_t& newest = newest_[number];
  newest = newest + 1u == config_.rt.prefetcher.records ? std::uint8_t{0} : static_cast<std::uint8_t>(newest + 1);
  records_of(number)[newest] = {node.child_base, end, event.node, static_cast<std::uint8_t>(event.pushed()), true};
}

// As SiblingPrefetcher: the first of the hit children that is asked for brings the others.
Record* Machine::take_record(Number number, std::uint32_t address) {
  Record* const records = records_of(number);
  std::uint32_t within = 0;
  for (unsigned i = 0; i < config_.rt.prefetcher.records; ++i) {
    within |= std::uint32_t{address - records[i].begin < records[i].end - records[i].begin} << i;
  }
  if (within == 0) return nullptr;
  // The newest of them: the highest up to newest_, or else the highest.
  const std::uint32_t recent = within & ((2u << newest_[number]) - 1);
  Record& record = records[std::bit_width(recent != 0 ? recent : within) - 1];
  return std::exchange(record.armed, false) ? &record : nullptr;
}

void Machine::prefetch_siblings(Cycle now, const Lane& lane, Sm& sm, const Record& record, std::uint32_t address) {
  ++sm.rt.prefetch.triggers;
  unsigned t = 0;
  while (t < triggered_count_ && triggered_[t].definition != record.definition) ++t;
  if (t == triggered_count_) triggered_[triggered_count_++] = {record.definition, 0};
  unsigned siblings = 0;
  const bool idle = sm.ports[kPrefetch].queue.empty();
  for_each_sibling(group_of(lane).nodes[record.definition], record.hit, address,
                   [&](unsigned slot, NodeKind kind, std::uint32_t child) {
                     siblings |= 1u << slot;
                     if ((triggered_[t].asked >> slot & 1) != 0) {
                       ++sm.rt.prefetch.merged;
                     } else {
                       prefetch(sm, kind, std::uint64_t{child} * traces::kNodeUnit);
                     }
                   });
  triggered_[t].asked = static_cast<std::uint8_t>(triggered_[t].asked | siblings);
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
  push_node(sm, kPrefetch, 0, address, traffic_.sectors(kind), traffic_.region(kind, address), true);
}

}  // namespace grtx::sim::fast
