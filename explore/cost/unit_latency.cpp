// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/unit_latency.h"

#include <fmt/format.h>

#include <cmath>

#include "grtx/base/error.h"
#include "grtx/explore/cost/operator_cost.h"

namespace grtx::explore {
namespace {

constexpr double kAdd = 3.37, kMul = 2.86, kMinMax = 0.71, kLess = 0.50;

}  // namespace

const std::vector<OperatorChain>& operator_chains() {
  static const std::vector<OperatorChain> chains = {
      {"ray_box", {kAdd, kMul, kMinMax, kMinMax, kMinMax, kLess}},
      {"ray_triangle", {kAdd, kMul, kAdd, kMul, kAdd, kAdd}},
      {"ray_sphere", {kMul, kAdd, kAdd, kMul, kAdd}},
      {"ray_gaussian", {kMul, kAdd, kAdd, kMul, kMul, kAdd, kMul, kAdd, kMul, kLess}},
      {"ray_transform", {kMul, kAdd, kAdd}},
  };
  return chains;
}

unsigned cycles_needed(const OperatorChain& chain, double delay_factor, double clock_mhz) {
  const double logic_ns = 1e3 / clock_mhz - kFlipFlopDelayNs;
  if (!(logic_ns > 0.0)) {
    throw Error("gpu.core_mhz", fmt::format("{:g}", clock_mhz), "leaves no time beside a register's 0.1 ns");
  }
  unsigned cycles = 0;
  for (const double delay : chain.delays_ns) {
    cycles += static_cast<unsigned>(std::ceil(delay * delay_factor / logic_ns));
  }
  return cycles;
}

}  // namespace grtx::explore
