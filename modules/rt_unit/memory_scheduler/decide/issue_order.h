// SPDX-License-Identifier: Apache-2.0
// In which order fetches are issued with rt.memory.oldest_warp_first. Without it they leave as they were opened.
#pragma once

#include <cstddef>
#include <cstdint>

namespace grtx::modules {

/// What the order looks at in a fetch that waits to be issued.
struct WaitingFetch {
  std::uint64_t age = 0;  ///< of its warp: number of the call, so the oldest is the least
  bool begun = false;     ///< a sector of it has been issued
};

/// Place of a fetch that is opened for a warp of this age behind `waiting` others: before those of younger warps, but
/// behind one that has begun. at(i): the fetch at place i.
template <typename At>
std::size_t oldest_first_place(std::uint64_t age, std::size_t waiting, At&& at) {
  std::size_t place = waiting;
  for (; place > 0; --place) {
    const WaitingFetch before = at(place - 1);
    if (before.begun || before.age <= age) break;
  }
  return place;
}

}  // namespace grtx::modules
