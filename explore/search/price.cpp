// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/search/price.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::explore {

const std::map<std::string, double>& Prices::costs(const SweepPoint& point) {
  const sim::MachineUse& use = point.use;
  const std::string machine = fmt::format("{} {}", fmt::join(cost_arguments(use), " "), point.config.text());
  if (const auto found = costs_.find(machine); found != costs_.end()) return found->second;
  ChildProcess child("cost of " + point.design, [&] {
    const sim::GpuConfig config = config_from(point.config.json());
    return json_text(cost_json(machine_cost(config, use.design, sim::machine_inventory(config, use), CostOptions())));
  });
  std::map<std::string, double>& prices = costs_[machine];
  for (const CostValue& cost : cost_values(parse_json(child.result(), "cost"))) {
    prices[cost.name] = cost.value;
  }
  return prices;
}

}  // namespace grtx::explore
