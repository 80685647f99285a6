// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/operator_cost.h"

#include <fmt/format.h>

#include <vector>

#include "grtx/base/declare/named_enum.h"

namespace grtx::explore {
namespace {

// GE low: smallest of five liberty sets synthesised with Yosys; high: published areas at 45 nm (the table usually
// printed with Horowitz, ISSCC 2014; TRaX for min/max); central: their geometric mean. Energy low: Horowitz; central:
// toggle counts in Nangate45 with 1 fF a pin; high: Aladdin at 40 nm, power times the 1 ns clock.
constexpr OperatorCost kOperatorCosts[] = {
    {"fp_add",
     32,
     false,
     {1650, 2900, 5250},
     2077,
     {0.9, 3.45, 5.56},
     3.37,
     "Yosys/Nangate45; Horowitz 2014; Aladdin",
     'A'},
    {"fp_mul",
     32,
     false,
     {4800, 6900, 9650},
     5684,
     {3.7, 9.64, 11.8},
     2.86,
     "Yosys/Nangate45; Horowitz 2014; Aladdin",
     'A'},
    {"fp_fma", 32, false, {9000, 10500, 14000}, 9722, {4.6, 15.4, 18.9}, 6.14, "Yosys/Nangate45; FPMax (28 nm)", 'B'},
    {"fp_compare",
     32,
     false,
     {200, 290, 600},
     292,
     {0.15, 0.36, 0.54},
     0.71,
     "Yosys/Nangate45 min/max; TRaX FPMIN at 65 nm",
     'A'},
    {"fp_reciprocal",
     32,
     false,
     {2100, 8270, 92600},
     8266,
     {4.6, 13.5, 80.0},
     12.2,
     "low: radix-2 iterative; central: Yosys/OSU 180 nm, 25 rows of long division; high: TRaX FPINV",
     'C'},
    {"fp_square_root", 32, false, {2100, 8270, 92600}, 0, {4.6, 13.5, 80.0}, 12.2, "as the reciprocal", 'C'},
    // Compare-and-exchange of two keyed children: 6-input network of 12 synthesised to 6,684 GE with 216 flip-flops.
    {"exchange", 36, true, {400, 455, 900}, 455, {0.3, 0.7, 1.1}, 0.9, "Yosys/Nangate45: sort of 6 children", 'B'},
    {"int_add", 32, true, {218, 240, 269}, 263, {0.1, 0.41, 0.57}, 1.05, "Yosys, five libraries; Horowitz; TRaX", 'A'},
    {"int_compare",
     32,
     true,
     {138, 138, 276},
     138,
     {0.03, 0.08, 0.15},
     0.40,
     "Yosys/Nangate45 less-than; Accelergy comparator",
     'B'},
    {"increment", 32, true, {90, 120, 160}, 0, {0.05, 0.2, 0.3}, 0.6, "half an adder", 'C'},
    // x 20 = x 16 + x 4: one adder.
    {"mul_constant", 32, true, {218, 240, 269}, 0, {0.1, 0.41, 0.57}, 1.05, "one int_add", 'C'},
    // XNOR a bit and an AND tree. A 32-lane match leader synthesised to 6,572 GE with 73 flip-flops for 48-bit
    // addresses.
    {"match",
     48,
     true,
     {90, 125, 196},
     0,
     {0.03, 0.06, 0.12},
     0.45,
     "Yosys/Nangate45: line coalescer of 32 lanes",
     'B'},
    {"mux", 32, true, {48, 64, 80}, 0, {0.02, 0.05, 0.1}, 0.2, "2 GE per bit", 'C'},
    // Age matrix of n entries: 564 GE at 8, 9,256 at 32 with its n^2 flip-flops; 3.1 GE a cell is logic.
    {"arbiter", 8, true, {50, 100, 200}, 0, {0.1, 0.2, 0.4}, 0.45, "Yosys/Nangate45: age matrix", 'B'},
};

}  // namespace

std::span<const OperatorCost> operator_costs() { return kOperatorCosts; }

OperatorCost operator_cost(const std::string& name, unsigned width) {
  for (const OperatorCost& known : operator_costs()) {
    if (known.name != name) continue;
    if (known.width == width) return known;
    if (!known.per_bit) break;
    OperatorCost scaled = known;
    const double factor = static_cast<double>(width) / known.width;
    scaled.width = width;
    scaled.gates = known.gates * factor;
    scaled.measured_gates = known.measured_gates * factor;
    scaled.energy_pj = known.energy_pj * factor;
    return scaled;
  }
  std::vector<std::string> names;
  for (const OperatorCost& known : operator_costs()) {
    if (known.name == name) {
      throw Error("inventory", "operator " + name, fmt::format("has a cost of {} bits, not of {}", known.width, width));
    }
    names.emplace_back(known.name);
  }
  throw Error("inventory", "operator " + name, unknown_name(name, names));
}

}  // namespace grtx::explore
