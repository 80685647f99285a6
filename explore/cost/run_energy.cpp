// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/run_energy.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/explore/cost/operator_cost.h"
#include "grtx/explore/cost/technology.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::explore {
namespace {

using modules::Inventory;

// The first module whose hierarchical name ends in this name; nullptr if there is none.
const Inventory* module_of(const std::vector<Inventory>& all, const std::string& end) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Inventory& i) { return i.module.ends_with(end); });
  return found == all.end() ? nullptr : &*found;
}

const CostItem* item_of(const std::vector<CostItem>& items, const std::string& name) {
  const auto found = std::find_if(items.begin(), items.end(), [&](const CostItem& i) { return i.name == name; });
  return found == items.end() ? nullptr : &*found;
}

/// Whether runs can have a statistic of this name; guards against misspelt names, which would cost nothing.
bool is_declared(const std::string& name) {
  static const std::set<std::string> names = [] {
    std::set<std::string> all;
    const modules::StatisticList listed = sim::all_statistics();
    for (const modules::Statistic& statistic : listed.items()) all.insert(statistic.name);
    return all;
  }();
  return names.contains(name);
}

class Prices {
 public:
  Prices(const std::vector<Inventory>& inventories, const CostOptions& options)
      : inventories_(inventories), options_(options), technology_(technology(options.nm)) {}

  /// Energy of one test: all operators of one pipeline once, and a register per stage. The inventory is the sum over
  /// all pipelines; each uses its operators and registers `interval` times per test.
  Range test(const modules::EnergyTerm& unit) const {
    const Inventory* inventory = module_of(inventories_, "." + unit.module);
    if (inventory == nullptr) return {};
    Range pj;
    for (const CostItem& item : price(*inventory, options_)) {
      if (item.kind == CostItemKind::logic) pj += item.operation_pj * (item.count / unit.pipelines * unit.interval);
      if (item.name == "pipeline_registers") {
        pj +=
            kFlipFlopEnergyPj * technology_.energy * (static_cast<double>(item.bits) / unit.pipelines * unit.interval);
      }
    }
    return pj;
  }
  /// Energy of one memory access; band of 0.7 to 1.4 for interpolation and organisation (judgement).
  Range access(const std::string& module, const std::string& memory, bool write) const {
    const Inventory* inventory = module_of(inventories_, module);
    if (inventory == nullptr) return {};
    const std::vector<CostItem> items = price(*inventory, options_);
    const CostItem* item = item_of(items, memory);
    if (item == nullptr) return {};
    const double pj = write ? item->write_pj : item->read_pj;
    return {0.7 * pj, pj, 1.4 * pj};
  }
  Range operation(const std::string& name, unsigned width) const {
    return operator_cost(name, width).energy_pj * technology_.energy;
  }
  Range term(const modules::EnergyTerm& term) const {
    using Of = modules::EnergyTerm::Of;
    const Range pj = term.of == Of::test        ? test(term)
                     : term.of == Of::operation ? operation(term.item, term.width)
                                                : access("." + term.module, term.item, term.of == Of::write);
    return pj * term.times;
  }

 private:
  const std::vector<Inventory>& inventories_;
  const CostOptions& options_;
  const Technology& technology_;
};

/// Rounds to whole picojoules: logarithms differ in the last bit between mathematical libraries, and sums of integers
/// do not depend on their order.
Range in_whole_picojoules(const Range& nanojoules) {
  const auto whole = [](double nj) { return std::round(nj * 1e3) / 1e3; };
  return {whole(nanojoules.low), whole(nanojoules.central), whole(nanojoules.high)};
}

/// The parts of a run's energy so far, and what they are made from.
struct Account {
  const RunStatistics& counted;
  const std::string& statistics;
  Prices prices;
  std::vector<EnergyPart> parts;

  double value(const std::string& name) const {
    if (!is_declared(name)) throw std::logic_error("no statistic is called " + name);
    const std::optional<double> found = counted(name);
    if (!found && !name.starts_with("gpu.dram.")) {
      throw Error(statistics, name, "is missing, or no number: the energy of the run cannot be told");
    }
    return found.value_or(0.0);
  }
  /// Counters of a part that is off by default, or somebody's own; missing in a run if they are zero.
  double if_any(const std::string& name) const { return counted(name).value_or(0.0); }
  void add(const std::string& name, double actions, const Range& pj, const std::string& basis) {
    parts.push_back({name, actions, in_whole_picojoules(pj * (actions * 1e-3)), basis});
  }
};

void add_action(Account& account, const modules::EnergyAction& action) {
  double actions = 0.0;
  for (const std::string& name : action.statistics) {
    actions += action.off_by_default ? account.if_any(name) : account.value(name);
  }
  Range pj;
  for (const modules::EnergyTerm& term : action.terms) pj += account.prices.term(term);
  account.add(action.name, actions * action.factor, pj, action.basis);
}

void add_shaders(Account& account) {
  const Prices& prices = account.prices;
  // 32 lanes compute and access their registers whether or not they are masked: an upper bound for masked lanes.
  account.add("simt", account.value("gpu.simt.instructions.total"),
              prices.operation("fp_fma", 32) * 32.0 + prices.access(".simt", "register_file", false) * 3.0 +
                  prices.access(".simt", "register_file", true),
              "warp instructions, 32 lanes");
}

/// Where an action is listed: tests first, then the RT unit's memories, behind the SIMT core what is in its registers.
int place_of(const modules::EnergyAction& action) {
  const auto any = [&](const auto& is) { return std::any_of(action.terms.begin(), action.terms.end(), is); };
  if (any([](const modules::EnergyTerm& term) { return term.of == modules::EnergyTerm::Of::test; })) return 0;
  return any([](const modules::EnergyTerm& term) { return term.module == "simt"; }) ? 2 : 1;
}

void add_rt_unit_and_shaders(Account& account, const sim::GpuConfig& config) {
  const std::vector<modules::PartInfo> parts = modules::part_table(config.rt, config.own);
  for (int place = 0; place < 3; ++place) {
    if (place == 2) add_shaders(account);
    for (const modules::PartInfo& part : parts) {
      for (const modules::EnergyAction& action : part.energy) {
        if (place_of(action) == place) add_action(account, action);
      }
    }
  }
}

void add_memory(Account& account, const CostOptions& options, const EnergyOptions& energy) {
  const Prices& prices = account.prices;
  const double l1_reads = account.value("gpu.l1.all.reads");
  const double l1_writes = account.value("gpu.l1.all.writes") + account.value("gpu.l1.fills");
  account.add("l1.reads", l1_reads, prices.access(".l1d", "data", false), "sectors");
  account.add("l1.writes", l1_writes, prices.access(".l1d", "data", true), "sectors written and filled");
  const double packets = account.value("gpu.crossbar.request.packets") + account.value("gpu.crossbar.reply.packets");
  const double wire_pj = energy.wire_fj_per_bit_mm_40nm * 1e-3 * 8 * (32 + 8) / 2 * energy.wire_mm *
                         std::sqrt(options.nm / 40.0);  // 240 at 40 nm, 115 at 10 nm: the square root of the node
  account.add("crossbar", packets, {0.5 * wire_pj, wire_pj, 2.0 * wire_pj}, "packets; half of them carry a sector");
  account.add("l2.reads", account.value("gpu.l2.all.reads"), prices.access("l2_slice0", "data", false), "sectors");
  account.add("l2.writes", account.value("gpu.l2.all.writes") + account.value("gpu.dram.reads"),
              prices.access("l2_slice0", "data", true), "sectors written and filled");
  const double dram_pj = 8.0 * energy.dram_pj_per_bit;
  account.add("dram", account.value("gpu.dram.bytes"), {0.8 * dram_pj, dram_pj, 1.9 * dram_pj},
              "bytes; HBM2E to GDDR5");
}

}  // namespace

std::vector<EnergyPart> run_energy(const RunStatistics& counted, const sim::GpuConfig& config,
                                   const std::vector<modules::Inventory>& inventories, const CostOptions& options,
                                   const EnergyOptions& energy, const std::string& statistics) {
  Account account{counted, statistics, Prices(inventories, options), {}};
  add_rt_unit_and_shaders(account, config);
  add_memory(account, options, energy);
  // User-defined units compute their own energy; the run's statistics hold the sum.
  if (const double own = counted("gpu.energy_nj.own").value_or(0.0); own > 0.0) {
    account.parts.push_back(
        {"own", 1.0, Range::exactly(own), "run, as units that not every machine has price what they count"});
  }
  const CostNode tree = cost_tree(inventories, options);
  account.add("leakage", account.value("gpu.time_us"), tree.leakage_mw * 1e3, "us of the whole machine");
  return account.parts;
}

Range total(const std::vector<EnergyPart>& parts) {
  Range sum;
  for (const EnergyPart& part : parts) sum += part.nanojoules;
  return in_whole_picojoules(sum);
}

}  // namespace grtx::explore
