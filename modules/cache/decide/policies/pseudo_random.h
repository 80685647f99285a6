// SPDX-License-Identifier: Apache-2.0
// Cache replacement random: evicts a random line of the set. The generator gives the same sequence on every host.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/cache/decide/replacement.h"

namespace grtx::modules {

class PseudoRandom final : public CacheReplacement {
 public:
  PseudoRandom(std::uint64_t sets, unsigned ways) : ways_(ways), victim_(sets) {}
  void filled(std::uint64_t set, unsigned, const MemoryRequest&) override {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX generator
    victim_[set] = static_cast<unsigned>((state_ >> 33) % ways_);
  }
  void referenced(std::uint64_t, unsigned, const MemoryRequest&) override {}
  unsigned victim(std::uint64_t set, const MemoryRequest&) const override { return victim_[set]; }
  unsigned bits_per_line() const override { return 0; }
  bool save(StateWriter& state) const override {
    state.put(state_);
    for (const unsigned way : victim_) state.put(way);
    return true;
  }
  void load(StateReader& state) override {
    state_ = state.get<std::uint64_t>();
    for (unsigned& way : victim_) way = state.get(ways_ - 1);
  }

 private:
  unsigned ways_;
  std::uint64_t state_ = 1;
  std::vector<unsigned> victim_;
};

}  // namespace grtx::modules
