// What a machine costs, without simulating it: the cost.* values that a finished point of it has.
#pragma once

#include <map>
#include <string>

#include "grtx/lab/sweep/points.h"

namespace grtx::sim {

class Prices {
 public:
  /// The machine of a point, by the name of the value. Each different machine is elaborated once, in a child process.
  const std::map<std::string, double>& of(const SweepPoint& point);

 private:
  std::map<std::string, std::map<std::string, double>> known_;  ///< by what the machine is made from
};

}  // namespace grtx::sim
