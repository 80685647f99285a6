// SPDX-License-Identifier: Apache-2.0
// Arithmetic operators: gate equivalents (GE), energy and delay, with the source of each number.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "grtx/explore/cost/range.h"
#include "grtx/modules/kernel/inventory.h"

namespace grtx::explore {

struct OperatorCost {
  std::string_view name;
  unsigned width = 32;          ///< operand width in bits that the numbers are valid for
  bool per_bit = false;         ///< gates and energy scale with the width; else no other width is supported
  Range gates;                  ///< GE
  double measured_gates = 0.0;  ///< GE synthesised (Yosys, Nangate45, timing-driven); 0: not measured
  Range energy_pj;              ///< per operation at 45 nm, 1.1 V, random operands
  double delay_ns = 0.0;        ///< at 45 nm (Nangate45, timing-driven)
  std::string_view source;
  char confidence = 'C';  ///< A measured and published, B one of the two, C judged
};

std::span<const OperatorCost> operator_costs();

/// Cost of one operator of `width` bits. Throws Error for an unknown name or width: the inventory of somebody's unit
/// then has an operator that the model cannot price.
OperatorCost operator_cost(const std::string& name, unsigned width);

/// GE and pJ (per clock at 45 nm) of a flip-flop bit, and its overhead in a cycle: clock to output, set-up and skew.
inline constexpr Range kFlipFlopGates = {4.0, 5.7, 7.5};            // measured 4.0-5.7; Aladdin's register at 40 nm
inline constexpr Range kFlipFlopEnergyPj = {0.0045, 0.009, 0.018};  // Aladdin: 9 fJ; band judged
inline constexpr double kFlipFlopDelayNs = 0.10;                    // assumption, at every node

}  // namespace grtx::explore
