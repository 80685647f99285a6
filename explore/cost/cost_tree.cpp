// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/cost_tree.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "grtx/explore/cost/operator_cost.h"
#include "grtx/explore/cost/sram_cost.h"
#include "grtx/explore/cost/technology.h"

namespace grtx::explore {
namespace {

// Sums of operator costs match synthesised units within +9 and -8 %. Libraries, clock targets and wiring vary more: a
// band of 0.6 to 1.8 around the central value (judgement) covers all published units. The band of a coefficient may be
// wider.
Range logic_area(const Range& gates, const Technology& t, const CostOptions& options) {
  return gates * t.um2_per_ge * (options.control / options.utilisation * 1e-6);
}

Range leakage(const Range& area_mm2, const Technology& t, const CostOptions& options) {
  // nW/um2 = mW/mm2; only cells leak.
  return area_mm2 * t.leakage_nw_per_um2 * options.utilisation;
}

CostItem flip_flops(const modules::Storage& storage, const Technology& t, const CostOptions& options) {
  CostItem item;
  item.name = storage.name;
  item.kind = CostItemKind::flip_flops;
  item.bits = storage.bits;
  item.gates = kFlipFlopGates * static_cast<double>(storage.bits);
  item.area_mm2 = logic_area(item.gates, t, options);
  item.leakage_mw = leakage(item.area_mm2, t, options);
  item.delay_ns = kFlipFlopDelayNs;
  const double word = std::min<double>(storage.word_bits, static_cast<double>(storage.bits));
  item.read_pj = item.write_pj = kFlipFlopEnergyPj.central * t.energy.central * word;
  item.estimator = "flip-flop bits";
  return item;
}

CostItem memory(const modules::Storage& storage, const Technology& t, const CostOptions& options) {
  if (storage.kind == modules::StorageKind::cache_tags) {
    CostItem item;
    item.name = storage.name;
    item.kind = CostItemKind::cache;
    item.bits = storage.bits;
    item.estimator = "in the data array's figures";
    return item;
  }
  const unsigned banks = std::max(1u, storage.banks);
  const std::uint64_t rows = storage.bits / banks / std::max(1u, storage.word_bits);
  if (storage.kind == modules::StorageKind::flip_flop || rows < kLeastSramRows) return flip_flops(storage, t, options);
  const bool cache = storage.kind == modules::StorageKind::cache;
  const SramCost sram =
      sram_cost({storage.bits / banks, storage.word_bits, cache, storage.write_ports > 0 && !cache, t.nm});
  CostItem item;
  item.name = storage.name;
  item.kind = cache ? CostItemKind::cache : CostItemKind::sram;
  item.bits = storage.bits;
  // Read ports beyond the first are further copies.
  const double copies = cache ? 1.0 : std::max(1u, storage.read_ports);
  item.area_mm2 = sram.area_mm2 * (copies * banks);
  item.leakage_mw = sram.leakage_mw * (copies * banks);
  item.delay_ns = sram.access_ns;
  item.read_pj = sram.read_pj;
  item.write_pj = sram.write_pj * copies;
  item.estimator = sram.estimator;
  return item;
}

CostItem operators(const modules::Operators& o, const Technology& t, const CostOptions& options) {
  const OperatorCost cost = operator_cost(o.name, o.width);
  CostItem item;
  item.name = o.name + std::to_string(o.width);
  item.kind = CostItemKind::logic;
  item.count = static_cast<double>(o.count);
  item.gates = cost.gates * static_cast<double>(o.count);
  item.area_mm2 = logic_area(item.gates, t, options);
  item.leakage_mw = leakage(item.area_mm2, t, options);
  item.delay_ns = cost.delay_ns * t.delay.central;
  item.operation_pj = cost.energy_pj * t.energy;
  item.estimator = cost.source;
  return item;
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    parts.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(path.substr(begin));
  return parts;
}

void sum(CostNode& node) {
  for (const CostItem& item : node.items) {
    (item.kind == CostItemKind::flip_flops ? node.flip_flop_bits : node.memory_bits) +=
        item.kind == CostItemKind::logic ? 0 : item.bits;
    node.gates += item.gates;
    node.area_mm2 += item.area_mm2;
    node.leakage_mw += item.leakage_mw;
    node.delay_ns = std::max(node.delay_ns, item.delay_ns);
  }
  for (CostNode& child : node.children) {
    sum(child);
    const double copies = child.copies;
    node.flip_flop_bits += child.copies * child.flip_flop_bits;
    node.memory_bits += child.copies * child.memory_bits;
    node.gates += child.gates * copies;
    node.area_mm2 += child.area_mm2 * copies;
    node.leakage_mw += child.leakage_mw * copies;
    node.delay_ns = std::max(node.delay_ns, child.delay_ns);
  }
}

bool equal(const CostNode& a, const CostNode& b) {
  return a.flip_flop_bits == b.flip_flop_bits && a.memory_bits == b.memory_bits && a.gates == b.gates &&
         a.area_mm2 == b.area_mm2 && a.items.size() == b.items.size() && a.children.size() == b.children.size();
}

std::string without_number(const std::string& name) {
  std::size_t end = name.size();
  while (end > 0 && std::isdigit(static_cast<unsigned char>(name[end - 1])) != 0) --end;
  return name.substr(0, end);
}

void fold(CostNode& node) {
  std::vector<CostNode> folded;
  for (CostNode& child : node.children) {
    fold(child);
    const auto twin = std::find_if(folded.begin(), folded.end(), [&](const CostNode& o) {
      return child.name != without_number(child.name) && without_number(o.name) == without_number(child.name) &&
             equal(o, child);
    });
    if (twin != folded.end()) {
      ++twin->copies;
    } else {
      folded.push_back(std::move(child));
    }
  }
  node.children = std::move(folded);
}

}  // namespace

std::vector<CostItem> price(const modules::Inventory& inventory, const CostOptions& options) {
  const Technology& t = technology(options.nm);
  std::vector<CostItem> items;
  for (const modules::Storage& storage : inventory.storage) {
    if (storage.bits == 0) continue;
    items.push_back(memory(storage, t, options));
    items.back().added_by_grtx = storage.added_by_grtx;
  }
  for (const modules::Operators& o : inventory.operators) {
    if (o.count != 0) items.push_back(operators(o, t, options));
  }
  return items;
}

CostNode cost_tree(const std::vector<modules::Inventory>& inventories, const CostOptions& options) {
  CostNode root;
  for (const modules::Inventory& inventory : inventories) {
    const std::vector<std::string> parts = parts_of(inventory.module);
    if (root.name.empty()) root.name = parts.front();
    if (inventory.storage.empty() && inventory.operators.empty()) continue;  // wires
    CostNode* node = &root;
    for (std::size_t i = parts.front() == root.name ? 1 : 0; i < parts.size(); ++i) {
      auto child = std::find_if(node->children.begin(), node->children.end(),
                                [&](const CostNode& c) { return c.name == parts[i]; });
      if (child == node->children.end()) {
        node->children.push_back({});
        node->children.back().name = parts[i];
        child = node->children.end() - 1;
      }
      node = &*child;
    }
    node->items = price(inventory, options);
  }
  CostNode summed = root;
  sum(summed);
  fold(summed);
  // Folding changes `copies` only; the sums stay those of one copy.
  return summed;
}

const CostNode* find(const CostNode& root, const std::string& path) {
  const CostNode* node = &root;
  for (const std::string& part : parts_of(path)) {
    const auto child =
        std::find_if(node->children.begin(), node->children.end(), [&](const CostNode& c) { return c.name == part; });
    if (child == node->children.end()) return nullptr;
    node = &*child;
  }
  return node;
}

}  // namespace grtx::explore
