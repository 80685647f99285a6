// SPDX-License-Identifier: Apache-2.0
// Load-store unit of the SIMT core: sends the sectors of shader phases to the L1 in order of arrival, one or more per
// cycle, and counts the outstanding loads and stores of each warp.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <vector>

#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/simt/decide/simt_core_config.h"

namespace grtx::modules {

/// No SystemC process. The tag of a request is its warp slot; `write` distinguishes loads from stores.
class LoadStoreUnit {
 public:
  LoadStoreUnit(unsigned resident_warps, std::uint8_t l1_client);

  /// Appends sectors of the warp in `slot` to the queue.
  void enqueue(unsigned slot, std::span<const SectorAccess> sectors, bool write);
  /// Sends the oldest requests, at most `most`, while `requests` has room in cycle `now`. Returns the number sent.
  unsigned send(Cycle now, const LinkWriter<MemoryRequest>& requests, unsigned most = 1);
  /// Whether a matching request is outstanding.
  bool expects(const MemoryResponse& response) const {
    const std::vector<std::uint32_t>& pending = response.write ? stores_pending_ : loads_pending_;
    return in_flight_ > 0 && response.tag < pending.size() && pending[response.tag] > 0;
  }
  /// Accounts for a response and returns its warp slot.
  unsigned receive(const MemoryResponse& response);

  /// Sectors of `slot` queued or in flight.
  std::uint32_t loads_pending(unsigned slot) const { return loads_pending_[slot]; }
  std::uint32_t stores_pending(unsigned slot) const { return stores_pending_[slot]; }
  bool empty() const { return size_ == 0; }                    ///< nothing waits to be sent
  bool idle() const { return size_ == 0 && in_flight_ == 0; }  ///< nothing waits for a response either
  std::uint64_t in_flight() const { return in_flight_; }
  std::size_t queued() const { return size_; }
  const LoadStoreCounters& counters() const { return counters_; }
  void dump_state(std::ostream& out) const;

 private:
  struct Waiting {
    std::uint64_t address = 0;
    std::uint16_t slot = 0;
    Region region = Region::ray;
    bool write = false;
  };
  void grow(std::size_t at_least);

  std::uint8_t client_;
  std::vector<Waiting> ring_;  ///< ring buffer, size a power of two, grows as needed
  std::size_t head_ = 0;
  std::size_t size_ = 0;
  std::uint64_t in_flight_ = 0;
  std::vector<std::uint32_t> loads_pending_;
  std::vector<std::uint32_t> stores_pending_;
  LoadStoreCounters counters_;
};

}  // namespace grtx::modules
