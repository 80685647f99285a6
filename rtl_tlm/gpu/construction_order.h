// SPDX-License-Identifier: Apache-2.0
// Builds parts in a chosen order, on which results must not depend: the kernel runs processes roughly in the order in
// which their modules were built, and tests shuffle it to find a model that relies on it.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace grtx::sim {

/// Calls every builder once: in the given order for seed 0, in an order that depends on the seed otherwise.
inline void construct(std::vector<std::function<void()>> builders, std::uint64_t seed) {
  if (seed != 0) {
    std::uint64_t state = seed;
    for (std::size_t i = builders.size(); i > 1; --i) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;  // Knuth's MMIX generator: same on every host
      std::swap(builders[i - 1], builders[(state >> 33) % i]);
    }
  }
  for (const auto& build : builders) build();
}

}  // namespace grtx::sim
