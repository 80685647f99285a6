// SPDX-License-Identifier: Apache-2.0
// Saves and restores the cache state beside the tags, for a run that another process continues.
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

/// Default of save() and load(): throws Error, because this user-supplied cache does not override them.
template <typename Cache>
[[noreturn]] void refuse_state(const Cache& cache) {
  throw Error("state", cache.name(), "does not say what it keeps");
}

}  // namespace grtx::modules
