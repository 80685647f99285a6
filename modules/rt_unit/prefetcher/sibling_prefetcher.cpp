// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/prefetcher/sibling_prefetcher.h"

#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/make_anew.h"

namespace grtx::modules {

SiblingPrefetcher::SiblingPrefetcher(const sc_core::sc_module_name& name, const Config& config,
                                     const Triggers& triggers, const NodeTraffic& traffic, unsigned entries)
    : PrefetchModule(name),
      config_(config),
      triggers_(triggers),
      lanes_(std::size_t{entries} * kMaxLanes),
      traffic_(traffic),
      decisions_(lanes_, config, triggers, traffic),
      queue_(config.queue > 0 ? config.queue : 1) {
  awake_ = false;
  require_allowed("rt.prefetch", config);
}

void SiblingPrefetcher::restart() {
  make_anew(decisions_, lanes_, config_, triggers_, traffic_);
  queue_.clear();
  awake_ = false;
  outstanding_ = 0;
}

bool SiblingPrefetcher::waits(std::uint64_t address) const {
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    if (queue_.at(i).address == address) return true;
  }
  return false;
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
  ++decisions_.counters().responses;
}

void SiblingPrefetcher::issue(Cycle now) {
  if (queue_.empty() || !requests_.can_push(now)) return;
  Pending& p = queue_.front();
  MemoryRequest message;
  const SectorRun node = traffic_.run(p.kind, p.address);
  message.address = node.address + kSectorBytes * p.next;
  message.region = node.region;
  message.prefetch = true;
  ++decisions_.counters().sectors;
  if (++p.next == node.sectors) queue_.pop();
  awake_ = !queue_.empty();
  requests_.push(now, message);
  ++outstanding_;
}

Inventory SiblingPrefetcher::inventory() const {
  Inventory inventory{name(), {}, {}};
  // A record: address of the first child (48 bits), hit mask, 3 bits of kind per child, armed bit.
  const std::uint64_t record = 48 + traces::kMaxWidth * (1 + 3) + 1;
  if (decisions_.triggers().siblings) {
    inventory.storage.push_back({"records", StorageKind::ram, decisions_.records().size() * record});
    inventory.operators.push_back({"match", 48, std::uint64_t{config_.records} * kMaxLanes});
  }
  // Per lane, for the source entry it has taken: mask of siblings, its own slot, mask of leaf children.
  if (decisions_.triggers().replayed) {
    const std::uint64_t lanes = decisions_.records().size() / config_.records;
    inventory.storage.push_back({"siblings_of_entry", StorageKind::ram, lanes * (traces::kMaxWidth * 2 + 3)});
  }
  inventory.storage.push_back({"queue", StorageKind::flip_flop, std::uint64_t{config_.queue} * (48 + 3 + 3)});
  return inventory;
}

void SiblingPrefetcher::dump_state(std::ostream& out) const {
  out << name() << ": " << queue_.size() << " nodes to prefetch, " << outstanding_ << " requests outstanding\n";
}

PartInfo part_info(const PrefetcherConfig&) {
  PartInfo part;
  part.name = "sibling_prefetcher";
  part.title = "prefetchers";
  part.statistics = {"gpu.rt.prefetch."};
  part.keys = {"rt.prefetch."};
  return part;
}

}  // namespace grtx::modules
