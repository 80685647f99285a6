// What caches keep beside their tags when a run is taken up by another process.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/state_bytes.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

inline void save_regions(const std::vector<Region>& regions, StateWriter& state) {
  for (const Region region : regions) state.put(static_cast<std::uint8_t>(region));
}

inline void load_regions(std::vector<Region>& regions, StateReader& state) {
  constexpr auto kLast = static_cast<std::uint8_t>(kCountOf<Region> - 1);
  for (Region& region : regions) region = static_cast<Region>(state.get(kLast));
}

/// For a cache of somebody else that has not overridden save() and load().
template <typename Cache>
[[noreturn]] void refuse_state(const Cache& cache) {
  throw Error("state", cache.name(), "does not say what it keeps");
}

}  // namespace grtx::modules
