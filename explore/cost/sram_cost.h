// SPDX-License-Identifier: Apache-2.0
// Memories: area, access time, energy and leakage from a table of CACTI 7.0 runs, interpolated.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/explore/cost/range.h"

namespace grtx::explore {

struct SramRequest {
  std::uint64_t bits = 0;
  unsigned word_bits = 32;  ///< bits per access
  bool cache = false;       ///< with tags; 128 B lines, 16 ways
  bool two_ports = false;   ///< one read and one write port
  unsigned nm = 45;
};

struct SramCost {
  Range area_mm2;
  double access_ns = 0.0;
  double read_pj = 0.0, write_pj = 0.0;
  Range leakage_mw;
  std::string estimator;  ///< e.g. "CACTI 7.0", "CACTI 7.0, scaled from 22 nm"
};

/// Minimum rows of an SRAM macro; smaller memories are built from flip-flops.
inline constexpr std::uint64_t kLeastSramRows = 64;

/// Log-log interpolation between the two neighbouring sizes, and at 28 nm between 32 and 22 nm. Below 22 nm: area from
/// the bit cell, time and energy from the 22 nm point scaled. Sizes above the table use several banks.
SramCost sram_cost(const SramRequest& request);

}  // namespace grtx::explore
