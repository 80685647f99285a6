// SPDX-License-Identifier: Apache-2.0
// Cycles that a data path needs at a process node and clock, from the delays of its chain of operators.
#pragma once

#include <string>
#include <vector>

namespace grtx::explore {

/// Operators along the critical path of a unit, a register after each. Delays in ns at 45 nm (Yosys, Nangate45,
/// timing-driven).
struct OperatorChain {
  std::string unit;  ///< ray_box, ray_triangle, ray_sphere, ray_gaussian, ray_transform
  std::vector<double> delays_ns;
};
/// Slab box: subtract, multiply, swap, two min/max, compare. Moeller-Trumbore: add, mul, add, mul, add, add. Sphere:
/// mul, add, add, mul, add. Gaussian: mul, add, add, mul, mul, add, mul, add, mul, compare. Transform: mul, add, add.
/// Without the sort of children and without reciprocals.
const std::vector<OperatorChain>& operator_chains();

/// Sum over the chain of ceil(delay x factor / (clock period - register overhead)). Throws Error if the clock period is
/// not longer than the register overhead.
unsigned cycles_needed(const OperatorChain& chain, double delay_factor, double clock_mhz);

}  // namespace grtx::explore
