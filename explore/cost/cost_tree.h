// SPDX-License-Identifier: Apache-2.0
// Cost of a machine: prices the inventory of every module for a process node and sums them by hierarchy.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/explore/cost/range.h"
#include "grtx/modules/kernel/inventory.h"

namespace grtx::explore {

struct CostOptions {
  unsigned nm = 12;
  double clock_mhz = 1365;
  double utilisation = 0.70;  ///< share of the placed area that is cells (judgement: 0.6 to 0.8)
  double control = 1.0;       ///< factor on logic for control and interconnect (judgement: 1 to 2.5)
};

enum class CostItemKind : std::uint8_t { flip_flops, sram, cache, logic };
constexpr auto enum_names(CostItemKind) {
  return names_in_order<CostItemKind>({"flip-flops", "SRAM", "cache", "logic"});
}

struct CostItem {
  std::string name;
  CostItemKind kind = CostItemKind::logic;
  std::uint64_t bits = 0;
  double count = 0.0;  ///< operators
  Range gates;         ///< GE; 0 for SRAM
  Range area_mm2;
  Range leakage_mw;
  double delay_ns = 0.0;                 ///< delay of the slowest operator, or access time of a memory; central value
  double read_pj = 0.0, write_pj = 0.0;  ///< per access of a memory
  Range operation_pj;                    ///< per operation of one operator
  bool added_by_grtx = false;
  std::string estimator;
};

struct CostNode {
  std::string name;     ///< last part of the hierarchical name
  unsigned copies = 1;  ///< number of equal siblings folded into this node; all values are per copy
  std::vector<CostItem> items;
  std::vector<CostNode> children;

  // Totals of one copy, including all nodes below it.
  std::uint64_t flip_flop_bits = 0, memory_bits = 0;
  Range gates, area_mm2, leakage_mw;
  double delay_ns = 0.0;  ///< slowest operator or memory below; not a path: units are pipelined
};

/// Builds the hierarchy from the dotted module names. Siblings that differ only in their number are folded.
CostNode cost_tree(const std::vector<modules::Inventory>& inventories, const CostOptions& options);

/// Cost items of one module.
std::vector<CostItem> price(const modules::Inventory& inventory, const CostOptions& options);

/// Node at a dotted path below the root, e.g. "sm0.rt"; folded copies are found under the name of the first. nullptr if
/// there is none.
const CostNode* find(const CostNode& root, const std::string& path);

}  // namespace grtx::explore
