// What a link between modules stores: its capacity in messages of a memory packet's width.
#pragma once

#include <cstdint>
#include <memory>
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

}  // namespace grtx::modules
