// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/unit_latency.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/explore/cost/operator_cost.h"

namespace grtx::explore {
namespace {

double delay_ns(const std::string& name) {
  static const std::map<std::string, double> delays = {{"add", 3.37}, {"mul", 2.86}, {"min_max", 0.71}, {"less", 0.50}};
  const auto found = delays.find(name);
  if (found == delays.end()) throw std::logic_error("no operator of a critical path is called " + name);
  return found->second;
}

}  // namespace

unsigned cycles_needed(const std::vector<std::string>& critical_path, double delay_factor, double clock_mhz) {
  const double logic_ns = 1e3 / clock_mhz - kFlipFlopDelayNs;
  if (!(logic_ns > 0.0)) {
    throw Error("gpu.core_mhz", fmt::format("{:g}", clock_mhz), "leaves no time beside a register's 0.1 ns");
  }
  unsigned cycles = 0;
  for (const std::string& name : critical_path) {
    cycles += static_cast<unsigned>(std::ceil(delay_ns(name) * delay_factor / logic_ns));
  }
  return cycles;
}

}  // namespace grtx::explore
