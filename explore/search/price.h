// SPDX-License-Identifier: Apache-2.0
// Costs of machines without simulating them: the cost.* values that a finished point would have.
#pragma once

#include <map>
#include <string>

#include "grtx/explore/sweep/points.h"

namespace grtx::explore {

class Prices {
 public:
  /// The cost.* values of a point's machine, by name. Each different machine is elaborated once, in a child process.
  const std::map<std::string, double>& costs(const SweepPoint& point);

 private:
  std::map<std::string, std::map<std::string, double>> costs_;  ///< by all inputs of the machine
};

}  // namespace grtx::explore
