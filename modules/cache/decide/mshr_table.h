// SPDX-License-Identifier: Apache-2.0
// Miss status holding registers: one entry per outstanding sector, each with a bounded list of requests waiting for it.
#pragma once

#include <cassert>
#include <cstdint>
#include <ostream>
#include <span>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

/// A waiting request without its address, which the entry holds. 8 B, so that 8 waiters fit one cache line of the host.
struct MshrWaiter {
  std::uint32_t tag = 0;
  std::uint8_t client = 0;
  std::uint8_t sm = 0;
  Region region = Region::tlas;
  bool write : 1 = false;
  bool prefetch : 1 = false;
};

/// Fully associative over sector addresses. `merges`: requests per entry, including the one that missed (as in
/// GPGPU-Sim's N:M notation).
class MshrTable {
 public:
  static constexpr std::uint32_t kNone = AddressIndex::kNone;

  MshrTable(unsigned entries, unsigned merges)
      : merges_(merges), index_(entries), entries_(entries), waiters_(std::size_t{entries} * merges) {
    assert(entries >= 1 && merges >= 1);
    free_.reserve(entries);
    for (unsigned i = entries; i > 0; --i) free_.push_back(i - 1);
  }

  /// Entry of a pending sector, or kNone.
  std::uint32_t find(std::uint64_t sector_address) const { return index_.find(sector_address / kSectorBytes); }
  /// Software prefetches into the host's cache, ahead of find() and of waiters() and release().
  void prefetch_find(std::uint64_t sector_address) const { index_.prefetch(sector_address / kSectorBytes); }
  void prefetch_entry(std::uint32_t entry) const {
    __builtin_prefetch(&entries_[entry]);
    __builtin_prefetch(&waiters_[std::size_t{entry} * merges_]);
  }
  bool full() const { return free_.empty(); }
  bool merges_full(std::uint32_t entry) const { return entries_[entry].count == merges_; }
  std::size_t used() const { return entries_.size() - free_.size(); }

  std::uint32_t allocate(Cycle now, std::uint64_t sector_address, const MemoryRequest& first) {
    assert(!full());
    const std::uint32_t entry = free_.back();
    free_.pop_back();
    index_.insert(sector_address / kSectorBytes, entry);
    entries_[entry] = {sector_address, now, 0, false};
    merge(entry, first);
    return entry;
  }
  void merge(std::uint32_t entry, const MemoryRequest& request) {
    Entry& e = entries_[entry];
    assert(e.count < merges_);
    waiters_[std::size_t{entry} * merges_ + e.count++] = {request.tag,    request.client, request.sm,
                                                          request.region, request.write,  request.prefetch};
    e.demand = e.demand || !request.prefetch;
  }
  std::span<const MshrWaiter> waiters(std::uint32_t entry) const {
    return {waiters_.data() + std::size_t{entry} * merges_, entries_[entry].count};
  }
  /// The request that missed.
  MemoryRequest first(std::uint32_t entry) const {
    const MshrWaiter& w = waiters(entry).front();
    return {entries_[entry].sector_address, w.tag, w.client, w.sm, w.region, w.write, w.prefetch};
  }
  std::uint64_t sector_address(std::uint32_t entry) const { return entries_[entry].sector_address; }
  Cycle allocated(std::uint32_t entry) const { return entries_[entry].allocated; }
  /// Whether at least one waiter is a demand access.
  bool demanded(std::uint32_t entry) const { return entries_[entry].demand; }
  bool in_use(std::uint32_t entry) const { return entry < entries_.size() && entries_[entry].count > 0; }
  void release(std::uint32_t entry) {
    assert(in_use(entry));
    index_.erase(entries_[entry].sector_address / kSectorBytes);
    entries_[entry].count = 0;
    free_.push_back(entry);
  }
  void dump_state(std::ostream& out) const {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const Entry& e = entries_[i];
      if (e.count == 0) continue;
      out << "  mshr " << i << ": sector 0x" << std::hex << e.sector_address << std::dec << " since cycle "
          << e.allocated << ", " << e.count << " waiting\n";
    }
  }

 private:
  struct Entry {
    std::uint64_t sector_address = 0;
    Cycle allocated = 0;
    std::uint32_t count = 0;
    bool demand = false;
  };

  unsigned merges_;
  AddressIndex index_;
  std::vector<Entry> entries_;
  std::vector<MshrWaiter> waiters_;
  std::vector<std::uint32_t> free_;
};

}  // namespace grtx::modules
