// SPDX-License-Identifier: Apache-2.0
// Cache replacement fifo: evicts the line that was filled first, regardless of hits.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/modules/cache/decide/replacement.h"

namespace grtx::modules {

class Fifo final : public CacheReplacement {
 public:
  Fifo(std::uint64_t sets, unsigned ways) : ways_(ways), next_(sets) {}
  void filled(std::uint64_t set, unsigned way, const MemoryRequest&) override {
    next_[set] = way + 1 == ways_ ? 0 : way + 1;
  }
  void referenced(std::uint64_t, unsigned, const MemoryRequest&) override {}
  unsigned victim(std::uint64_t set, const MemoryRequest&) const override { return next_[set]; }
  /// One counter per set, rounded up to 1 bit per line.
  unsigned bits_per_line() const override { return 1; }
  bool save(StateWriter& state) const override {
    for (const unsigned way : next_) state.put(way);
    return true;
  }
  void load(StateReader& state) override {
    for (unsigned& way : next_) way = state.get(ways_ - 1);
  }

 private:
  unsigned ways_;
  std::vector<unsigned> next_;
};

}  // namespace grtx::modules
