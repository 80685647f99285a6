// SPDX-License-Identifier: Apache-2.0
// Size and shape of a sectored cache, and their keys.
#pragma once

#include <bit>
#include <cstdint>
#include <string>

#include "grtx/modules/cache/decide/replacement.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

struct CacheGeometry {
  std::uint64_t bytes = 128 * 1024;
  unsigned line_bytes = 128;
  unsigned sector_bytes = 32;
  unsigned ways = 256;
  std::string replacement = "lru";  ///< one of cache_replacement_names()
  std::uint64_t sets() const { return bytes / (std::uint64_t{line_bytes} * ways); }  ///< rounded down
  unsigned sectors() const { return line_bytes / sector_bytes; }                     ///< per line, at most 8
  void shape_parameters(ParameterList& list) {
    list.add("line_bytes", line_bytes, {32, 256}, "B", "line; sectors are 32 B", kTable1);
    list.add("ways", ways, {1, 4096}, "ways", "associativity, LRU", kTable1);
    list.add("replacement", replacement, cache_replacement_names(),
             "which line of a full set is evicted; programs may register more policies", kOurs);
    list.rule(
        "line_bytes", [this] { return std::has_single_bit(line_bytes); }, "must be a power of two");
  }
};

}  // namespace grtx::modules
