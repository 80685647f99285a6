// SPDX-License-Identifier: Apache-2.0
// Capacity of links for the cost model, and their contents for dumps of a stalled run.
#pragma once

#include <cstdint>
#include <memory>
#include <ostream>
#include <vector>

#include "grtx/modules/kernel/link.h"

namespace grtx::modules {

inline constexpr unsigned kPacketBits = 40 * 8;  ///< one flit: 32 B of data and 8 B of header

/// Sum of the links' capacities, in messages.
template <typename T>
std::uint64_t total_capacity(const std::vector<std::unique_ptr<Link<T>>>& links) {
  std::uint64_t sum = 0;
  for (const auto& link : links) sum += link->capacity();
  return sum;
}

/// Prints one line if the link is not empty, for the dump of a stalled run.
template <typename T>
void dump_link(std::ostream& out, const Link<T>& link) {
  if (link.empty()) return;
  out << "  link " << link.name() << ": " << link.size() << " of " << link.capacity() << ", next visible in cycle "
      << link.next_visible() << '\n';
}

}  // namespace grtx::modules
