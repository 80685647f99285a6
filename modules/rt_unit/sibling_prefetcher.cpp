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
          .sum(&C::responses)
          .sum(&C::replayed)
          .sum(&C::entry_nodes)
          .sum(&C::entry_merged)
          .sum(&C::entry_dropped)
          .sum(&C::stack_looks)
          .sum(&C::stack_nodes)
          .sum(&C::stack_merged)
          .sum(&C::stack_dropped)
          .sum(&C::stack_culled)
          .described([](const C& c, StatisticList& list, const std::string& prefix) {
            if (list.lists_kinds() || c.replayed > 0) {
              list.add(prefix + ".replayed", c.replayed, "visits",
                       "replayed leaves whose siblings were prefetched, of the triggers");
            }
            if (list.lists_kinds() || c.entry_nodes > 0) {
              list.add(prefix + ".entry_nodes", c.entry_nodes, "nodes", "nodes of source entries queued for prefetch");
              list.add(prefix + ".entry_merged", c.entry_merged, "nodes",
                       "nodes of source entries that were queued to be prefetched already");
              list.add(prefix + ".entry_dropped", c.entry_dropped, "nodes",
                       "nodes of source entries dropped because the queue was full");
            }
            if (list.lists_kinds() || c.stack_looks > 0) {
              list.add(prefix + ".stack_looks", c.stack_looks, "looks",
                       "times that a lane's stack was looked at for nodes to prefetch");
              list.add(prefix + ".stack_nodes", c.stack_nodes, "nodes", "nodes of stack entries queued for prefetch");
              list.add(prefix + ".stack_merged", c.stack_merged, "nodes",
                       "nodes of stack entries that were queued to be prefetched already");
              list.add(prefix + ".stack_dropped", c.stack_dropped, "nodes",
                       "nodes of stack entries dropped because the queue was full; they may be asked for again");
              list.add(prefix + ".stack_culled", c.stack_culled, "nodes",
                       "nodes of stack entries queued for prefetch whose entry was culled in the end");
            }
          });
  return table;
}

SiblingPrefetcher::SiblingPrefetcher(const sc_core::sc_module_name& name, const Config& config,
                                     const Triggers& triggers, const NodeTraffic& traffic, unsigned entries)
    : PrefetchModule(name),
      config_(config),
      triggers_(triggers),
      traffic_(traffic),
      records_(std::size_t{entries} * kMaxLanes, config.records, triggers.replayed, traffic),
      stacks_(std::size_t{entries} * kMaxLanes, config.stack, traffic),
      queue_(config.queue > 0 ? config.queue : 1) {
  require_allowed("rt.prefetch", config);
}

void SiblingPrefetcher::note_leaf(LaneId id, const traces::RayGroup& group, std::uint32_t address) {
  const Siblings siblings = records_.take(id, group, address);
  if (siblings.mask == 0) return;
  ++counters_.triggers;
  if (siblings.replayed) ++counters_.replayed;
  const unsigned fresh = asked_.fresh(siblings);
  counters_.merged += static_cast<unsigned>(std::popcount(siblings.mask & ~fresh));
  records_.for_each_child(group.nodes[siblings.definition], fresh, [&](NodeKind kind, std::uint32_t child) {
    if (push(kind, traffic_.address(child), counters_.merged, counters_.dropped)) ++counters_.nodes;
  });
}

void SiblingPrefetcher::note_entry(NodeKind kind, std::uint64_t address) {
  if (push(kind, address, counters_.entry_merged, counters_.entry_dropped)) ++counters_.entry_nodes;
}

void SiblingPrefetcher::note_stack(LaneId id, std::uint32_t left, std::uint32_t on_chip) {
  const bool looked = stacks_.moved(id, left, on_chip, [&](const StackPrefetch::Node& node) {
    const std::uint64_t dropped = counters_.stack_dropped;
    if (push(node.kind, node.address, counters_.stack_merged, counters_.stack_dropped)) {
      ++counters_.stack_nodes;
      if (node.culled) ++counters_.stack_culled;
    }
    return counters_.stack_dropped == dropped;
  });
  if (looked) ++counters_.stack_looks;
}

// Whether it is queued; else which of the two is counted.
bool SiblingPrefetcher::push(NodeKind kind, std::uint64_t address, std::uint64_t& merged, std::uint64_t& dropped) {
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    if (queue_.at(i).address == address) {
      ++merged;
      return false;
    }
  }
  if (queue_.room() == 0) {
    ++dropped;
    return false;
  }
  queue_.push({address, kind, 0});
  return true;
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
  const SectorRun node = traffic_.run(p.kind, p.address);
  message.address = node.address + kSectorBytes * p.next;
  message.region = node.region;
  message.prefetch = true;
  ++counters_.sectors;
  if (++p.next == node.sectors) queue_.pop();
  requests_.push(now, message);
  ++outstanding_;
}

void SiblingPrefetcher::count(RtUnitCounters& all) const { all.prefetch.add(counters_); }

Inventory SiblingPrefetcher::inventory() const {
  Inventory inventory{name(), {}, {}};
  // A record: first child (48 bits), hit mask, three kind bits a child, armed.
  const std::uint64_t record = 48 + traces::kMaxWidth * (1 + 3) + 1;
  if (triggers_.siblings) {
    inventory.storage.push_back({"records", StorageKind::ram, records_.size() * record});
    inventory.operators.push_back({"match", 48, std::uint64_t{config_.records} * kMaxLanes});
  }
  // For the entry that a lane has taken: mask of its siblings, its own slot, which of the children are leaves.
  if (triggers_.replayed) {
    const std::uint64_t lanes = records_.size() / config_.records;
    inventory.storage.push_back({"siblings_of_entry", StorageKind::ram, lanes * (traces::kMaxWidth * 2 + 3)});
  }
  if (stacks_.enabled()) {
    // A copy of the addresses that are looked at, the top one included, with a bit that says which have been asked for:
    // the stack's own port serves the lanes. And pops in succession.
    const std::uint64_t bits = (stacks_.config().depth + std::uint64_t{1}) * (48 + 3 + 1);
    const std::uint64_t lanes = records_.size() / config_.records;
    inventory.storage.push_back(
        {"stack_tops", StorageKind::ram, lanes * bits, 1, 1, false, static_cast<unsigned>(bits)});
    if (stacks_.config().trigger == StackTrigger::pop) {
      const auto count = static_cast<unsigned>(std::bit_width(stacks_.config().pops));
      inventory.storage.push_back({"pops", StorageKind::flip_flop, lanes * count});
    }
  }
  inventory.storage.push_back({"queue", StorageKind::flip_flop, std::uint64_t{config_.queue} * (48 + 3 + 3)});
  return inventory;
}

void SiblingPrefetcher::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " nodes to prefetch, " << outstanding_ << " requests outstanding\n";
}

}  // namespace grtx::modules
