// SPDX-License-Identifier: Apache-2.0
// The functional (untimed) access path through the memory hierarchy, for sampled runs. Every event, timed or not,
// touches its sectors when it begins, and this alone updates the tags of L1 and L2. A timed request carries the hit or
// miss result of its touch.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <systemc>

#include "grtx/base/error.h"
#include "grtx/base/strong.h"
#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// A read or write of up to eight sectors.
struct Touch {
  std::uint64_t address = 0;  ///< of the first sector
  std::uint8_t sectors = 0;   ///< bit i: the sector at address + i * kSectorBytes
  Region region{};
  bool write = false;
  bool prefetch = false;
  Cycle at = 0;  ///< cycle of the access, not later than now
};

/// Result of a touch, as masks in the bit positions of Touch::sectors.
struct Touched {
  std::uint8_t missed = 0;        ///< misses in the first cache on the path
  std::uint8_t missed_below = 0;  ///< misses in the next cache, too
};

/// Implemented by caches and by networks that lead to one.
class touch_if : public virtual sc_core::sc_interface {
 public:
  virtual Touched touch(const Touch& access) = 0;
};

/// Implemented by the SIMT core: functional accesses of an any-hit batch whose events are not timed.
class shader_touch_if : public virtual sc_core::sc_interface {
 public:
  virtual void touch_any_hit(const AnyHitBatch& batch, Cycle at) = 0;
};

/// The functional interface of a unit. Throws Error if a user-supplied unit does not implement it.
template <typename Interface>
Interface& functional(sc_core::sc_module& unit) {
  if (auto* entry = dynamic_cast<Interface*>(&unit)) return *entry;
  throw Error("configuration", unit.name(), "has no functional entry, which a sampled run needs");
}

/// Bound only in sampled runs.
template <typename Interface>
using TouchPort = sc_core::sc_port<Interface, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;

inline constexpr unsigned kTouchBytes = 8 * kSectorBytes;  ///< largest span of a touch

/// Splits a touch at aligned blocks of `bytes` (a power of two), calls f(block address, sector mask) for each, and
/// merges the results.
template <typename F>
Touched for_each_block(const Touch& access, unsigned bytes, F&& f) {
  bytes = std::min(bytes, kTouchBytes);
  const auto in_block = static_cast<unsigned>(bytes / kSectorBytes);
  const unsigned all = (1u << in_block) - 1;
  std::uint64_t block = access.address & ~std::uint64_t{bytes - 1u};
  const auto lead = static_cast<unsigned>((access.address - block) / kSectorBytes);
  unsigned missed = 0, missed_below = 0;
  unsigned left = unsigned{access.sectors} << lead;
  for (unsigned at = 0; left != 0; block += bytes, left >>= in_block, at += in_block) {
    if ((left & all) == 0) continue;
    const Touched found = f(block, static_cast<std::uint8_t>(left & all));
    missed |= unsigned{found.missed} << at;
    missed_below |= unsigned{found.missed_below} << at;
  }
  return {static_cast<std::uint8_t>(missed >> lead), static_cast<std::uint8_t>(missed_below >> lead)};
}

/// Touches the sectors of a shader's loads or stores in order; consecutive sectors of one region within kTouchBytes
/// form one touch. Stores the result in each SectorAccess.
inline void touch_all(touch_if& cache, std::span<SectorAccess> sectors, bool write, Cycle at) {
  for (std::size_t i = 0; i < sectors.size();) {
    Touch access{sectors[i].address & ~std::uint64_t{kTouchBytes - 1u}, 0, sectors[i].region, write, false, at};
    const auto place = [&](std::size_t j) { return (sectors[j].address - access.address) / kSectorBytes; };
    std::size_t end = i;
    for (; end < sectors.size() && sectors[end].region == access.region && place(end) < 8; ++end) {
      access.sectors |= static_cast<std::uint8_t>(1u << place(end));
    }
    const Touched found = cache.touch(access);
    for (; i < end; ++i) {
      sectors[i].missed = (found.missed >> place(i) & 1) != 0;
      sectors[i].missed_below = (found.missed_below >> place(i) & 1) != 0;
    }
  }
}

}  // namespace grtx::modules
