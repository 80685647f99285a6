// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/load_store_unit.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>
#include <ostream>

namespace grtx::modules {

std::uint64_t LoadStoreCounters::sectors() const {
  return std::accumulate(loads.begin(), loads.end(), std::uint64_t{0}) +
         std::accumulate(stores.begin(), stores.end(), std::uint64_t{0});
}

LoadStoreUnit::LoadStoreUnit(unsigned resident_warps, std::uint8_t l1_client)
    : client_(l1_client), ring_(1024), loads_pending_(resident_warps), stores_pending_(resident_warps) {}

void LoadStoreUnit::grow(std::size_t at_least) {
  std::vector<Waiting> larger(std::bit_ceil(at_least));
  for (std::size_t i = 0; i < size_; ++i) larger[i] = ring_[(head_ + i) & (ring_.size() - 1)];
  ring_.swap(larger);
  head_ = 0;
}

void LoadStoreUnit::enqueue(unsigned slot, std::span<const SectorAccess> sectors, bool write) {
  if (size_ + sectors.size() > ring_.size()) grow(size_ + sectors.size());
  const std::size_t mask = ring_.size() - 1;
  auto& by_region = write ? counters_.stores : counters_.loads;
  for (const SectorAccess& sector : sectors) {
    ring_[(head_ + size_) & mask] = {sector.address, static_cast<std::uint16_t>(slot), sector.region, write};
    ++size_;
    ++by_region[static_cast<std::size_t>(sector.region)];
  }
  (write ? stores_pending_ : loads_pending_)[slot] += static_cast<std::uint32_t>(sectors.size());
  counters_.deepest_queue = std::max<std::uint64_t>(counters_.deepest_queue, size_);
}

unsigned LoadStoreUnit::send(Cycle now, const LinkWriter<MemoryRequest>& requests, unsigned most) {
  unsigned sent = 0;
  for (; sent < most && size_ != 0; ++sent) {
    const Waiting& oldest = ring_[head_];
    MemoryRequest request;
    request.address = oldest.address;
    request.tag = oldest.slot;
    request.client = client_;
    request.region = oldest.region;
    request.write = oldest.write;
    if (!requests.try_push(now, request)) {
      if (sent == 0) ++counters_.blocked_cycles;
      break;
    }
    head_ = (head_ + 1) & (ring_.size() - 1);
    if (--size_ == 0) head_ = 0;  // reuses the same few cache lines of the host
    ++in_flight_;
  }
  return sent;
}

unsigned LoadStoreUnit::receive(const MemoryResponse& response) {
  const auto slot = static_cast<unsigned>(response.tag);
  std::uint32_t& pending = (response.write ? stores_pending_ : loads_pending_)[slot];
  assert(in_flight_ > 0 && pending > 0);
  --in_flight_;
  --pending;
  return slot;
}

void LoadStoreUnit::dump_state(std::ostream& out) const {
  out << "  load-store unit: " << size_ << " sectors queued, " << in_flight_ << " in flight\n";
}

}  // namespace grtx::modules
