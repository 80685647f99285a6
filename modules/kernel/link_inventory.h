// What a link between modules stores: its capacity in messages of a memory packet's width, and what is in it now.
#pragma once

#include <cstdint>
#include <memory>
#include <ostream>
#include <vector>

#include "grtx/modules/kernel/link.h"

namespace grtx::modules {

inline constexpr unsigned kPacketBits = 40 * 8;  ///< one flit: 32 B of data and 8 B of header

/// Messages that all these links hold.
template <typename T>
std::uint64_t total_capacity(const std::vector<std::unique_ptr<Link<T>>>& links) {
  std::uint64_t sum = 0;
  for (const auto& link : links) sum += link->capacity();
  return sum;
}

/// A line of a link that is not empty, for a run that stands still.
template <typename T>
void dump_link(std::ostream& out, const Link<T>& link) {
  if (link.empty()) return;
  out << "  link " << link.name() << ": " << link.size() << " of " << link.capacity() << ", next visible in cycle "
      << link.next_visible() << '\n';
}

}  // namespace grtx::modules
