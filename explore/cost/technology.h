// SPDX-License-Identifier: Apache-2.0
// Process nodes: area and leakage of a gate, and factors of delay and energy relative to 45 nm, where operators were
// measured.
#pragma once

#include <string>
#include <vector>

#include "grtx/explore/cost/range.h"

namespace grtx::explore {

struct Technology {
  unsigned nm = 45;
  double volts = 1.1;        ///< nominal supply
  Range um2_per_ge;          ///< um^2 of a gate equivalent (smallest two-input NAND), unplaced
  Range delay;               ///< relative to 45 nm
  Range energy;              ///< relative to 45 nm at 1.1 V
  Range leakage_nw_per_um2;  ///< of logic
  std::string source;
  char confidence = 'C';  ///< A measured library, B published density, C interpolated
};

/// Supported nodes, nm: 45, 32, 28, 22, 16, 12, 7, 5.
const std::vector<unsigned>& technology_nodes();
/// Throws Error for an unsupported node; the message lists the supported ones.
const Technology& technology(unsigned nm);

/// Stillmaker and Baas (Integration, 2017), high-performance devices; log-log interpolation between the table's nodes,
/// below 7 nm extrapolation from 10 and 7 nm. Values are relative to 45 nm at 1.0 V, each node at its nominal supply.
double stillmaker_area(double nm);
double stillmaker_delay(double nm);
double stillmaker_energy(double nm);

}  // namespace grtx::explore
