// Process nodes: what a gate costs, and how delay and energy scale from the 45 nm node at which operators were
// measured.
#pragma once

#include <string>
#include <vector>

#include "grtx/lab/cost/range.h"

namespace grtx::sim {

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

/// 45, 32, 28, 22, 16, 12, 7, 5.
const std::vector<unsigned>& technology_nodes();
/// Throws Error naming the known nodes.
const Technology& technology(unsigned nm);

/// Stillmaker and Baas (Integration, 2017), high-performance devices; nodes between two of the table on a log-log line,
/// below 7 nm on the line through 10 and 7 nm. Relative to 45 nm at 1.0 V, each at its nominal supply.
double stillmaker_area(double nm);
double stillmaker_delay(double nm);
double stillmaker_energy(double nm);

}  // namespace grtx::sim
