// How many cycles a data path needs at a node and clock, from the delays of its operators in a row.
#pragma once

#include <string>
#include <vector>

namespace grtx::sim {

/// Delays at 45 nm, ns, of the operators along the path, a register after each (Yosys, Nangate45, timing-driven).
struct OperatorChain {
  std::string unit;  ///< ray_box, ray_triangle, ray_sphere, ray_transform
  std::vector<double> delays_ns;
};
/// Slab box: subtract, multiply, swap, two min/max, compare. Moeller-Trumbore: add, mul, add, mul, add, add. Sphere:
/// mul, add, add, mul, add. Transform: mul, add, add. The sort of children and reciprocals are not in them.
const std::vector<OperatorChain>& operator_chains();

/// Sum over the chain of ceil(delay x factor / (clock period - register overhead)). Throws Error when the clock leaves
/// no time for logic.
unsigned cycles_needed(const OperatorChain& chain, double delay_factor, double clock_mhz);

}  // namespace grtx::sim
