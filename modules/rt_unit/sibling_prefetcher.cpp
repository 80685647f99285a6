#include "grtx/modules/rt_unit/sibling_prefetcher.h"

#include <bit>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"

namespace grtx::modules {

using traces::NodeKind;

const CounterTable<SiblingPrefetcher::Counters>& SiblingPrefetcher::Counters::table() {
  using C = SiblingPrefetcher::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()

          .sum(&C::triggers, "triggers", "visits", "internal visits whose hit siblings were prefetched")
          .sum(&C::nodes, "nodes", "nodes", "sibling nodes queued for prefetch")
          .sum(&C::merged, "merged", "nodes", "sibling nodes that were on their way to be prefetched already")
          .sum(&C::dropped, "dropped", "nodes", "sibling nodes dropped because the queue was full")
          .sum(&C::sectors, "sectors", "requests", "32 B prefetch requests sent")
          .sum(&C::responses);
  return table;
}

SiblingPrefetcher::SiblingPrefetcher(const sc_core::sc_module_name& name, const Config& config,
                                     const NodeTraffic& traffic, unsigned entries)
    : PrefetchModule(name),
      config_(config),
      traffic_(traffic),
      records_(std::size_t{entries} * kMaxLanes * config.records),
      newest_(std::size_t{entries} * kMaxLanes),
      queue_(config.queue > 0 ? config.queue : 1) {
  require_allowed("rt.prefetch", config);
  for (const NodeKind kind : {NodeKind::internal, NodeKind::instance, NodeKind::triangle, NodeKind::procedural}) {
    units_[static_cast<std::size_t>(kind)] = static_cast<std::uint32_t>(traffic.stored_bytes(kind) / traces::kNodeUnit);
  }
}

void SiblingPrefetcher::note_internal(LaneId id, const traces::RayGroup& group, std::uint32_t definition,
                                      unsigned hit) {
  if (std::popcount(hit) < 2) return;  // no siblings
  const traces::NodeDefinition& node = group.nodes[definition];
  bool has_leaf = false;
  for_each_bit(hit, [&](unsigned i) { has_leaf = has_leaf || node.child_kinds[i] != NodeKind::internal; });
  if (!has_leaf) return;  // nothing could trigger it
  std::uint32_t end = node.child_base;
  for (unsigned i = 0; i < node.child_count; ++i) end += units_[static_cast<std::size_t>(node.child_kinds[i])];
  const unsigned newest = newest_[id] + 1u == config_.records ? 0 : newest_[id] + 1u;
  newest_[id] = static_cast<std::uint8_t>(newest);
  records_of(id)[newest] = {definition, node.child_base, end, static_cast<std::uint8_t>(hit), true};
}

void SiblingPrefetcher::note_leaf(LaneId id, const traces::RayGroup& group, std::uint32_t address) {
  Record* const records = records_of(id);
  unsigned next = newest_[id];
  for (unsigned back = 0; back < config_.records; ++back) {
    Record& record = records[next];
    next = next == 0 ? config_.records - 1 : next - 1;
    if (record.hit == 0) return;  // older ones are empty too
    if (address < record.begin || address >= record.end) continue;
    const traces::NodeDefinition& node = group.nodes[record.definition];
    // Children are contiguous in slot order.
    std::array<std::uint32_t, traces::kMaxWidth> child{};
    std::uint32_t at = node.child_base;
    unsigned demanded = traces::kMaxWidth;
    for (unsigned i = 0; i < node.child_count; ++i) {
      child[i] = at;
      if (at == address && (record.hit >> i & 1) != 0) demanded = i;
      at += units_[static_cast<std::size_t>(node.child_kinds[i])];
    }
    if (demanded == traces::kMaxWidth) continue;
    if (!record.armed) return;
    record.armed = false;
    ++counters_.triggers;
    const unsigned siblings = record.hit & ~(1u << demanded);
    unsigned t = 0;
    while (t < triggered_count_ && triggered_[t].definition != record.definition) ++t;
    if (t == triggered_count_) triggered_[triggered_count_++] = {record.definition, 0};
    const unsigned fresh = siblings & ~unsigned{triggered_[t].asked};
    counters_.merged += static_cast<unsigned>(std::popcount(siblings & ~fresh));
    triggered_[t].asked = static_cast<std::uint8_t>(triggered_[t].asked | siblings);
    for_each_bit(fresh, [&](unsigned i) { push(node.child_kinds[i], child[i] * traces::kNodeUnit); });
    return;
  }
}

void SiblingPrefetcher::push(NodeKind kind, std::uint64_t address) {
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    if (queue_.at(i).address == address) {
      ++counters_.merged;
      return;
    }
  }
  if (queue_.room() == 0) {
    ++counters_.dropped;
    return;
  }
  queue_.push({address, kind, 0});
  ++counters_.nodes;
}

void SiblingPrefetcher::end_of_elaboration() {
  requests_ = writer_of(request);
  responses_ = reader_of(response);
}

void SiblingPrefetcher::respond(Cycle now) {
  if (responses_.front(now) == nullptr) return;
  responses_.pop(now);
  assert(outstanding_ > 0);
  --outstanding_;
  ++counters_.responses;
}

void SiblingPrefetcher::issue(Cycle now) {
  if (queue_.empty() || !requests_.can_push(now)) return;
  Pending& p = queue_.front();
  MemoryRequest message;
  message.address = p.address + kSectorBytes * p.next;
  message.region = traffic_.region(p.kind, p.address);
  message.prefetch = true;
  ++counters_.sectors;
  if (++p.next == traffic_.sectors(p.kind)) queue_.pop();
  requests_.push(now, message);
  ++outstanding_;
}

void SiblingPrefetcher::count(RtUnitCounters& all) const { all.prefetch.add(counters_); }

Inventory SiblingPrefetcher::inventory() const {
  Inventory inventory{name(), {}, {}};
  // A record: first child (48 bits), hit mask, three kind bits a child, armed.
  const std::uint64_t record = 48 + traces::kMaxWidth * (1 + 3) + 1;
  inventory.storage.push_back({"records", StorageKind::ram, records_.size() * record});
  inventory.storage.push_back({"queue", StorageKind::flip_flop, std::uint64_t{config_.queue} * (48 + 3 + 3)});
  inventory.operators.push_back({"match", 48, std::uint64_t{config_.records} * kMaxLanes});
  return inventory;
}

void SiblingPrefetcher::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " nodes to prefetch, " << outstanding_ << " requests outstanding\n";
}

}  // namespace grtx::modules
