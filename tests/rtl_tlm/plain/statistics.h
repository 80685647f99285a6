// SPDX-License-Identifier: Apache-2.0
// Statistics of the plain model by their names in docs/model/statistics.md.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <string>

namespace grtx::sim::plain {

/// Values with their mean, largest and a histogram whose bin n holds values of n to 2n - 1.
struct Distribution {
  std::uint64_t count = 0, sum = 0, most = 0;
  std::map<std::uint64_t, std::uint64_t> bins;
  void add(std::uint64_t value) {
    ++count;
    sum += value;
    most = std::max(most, value);
    ++bins[std::bit_floor(value)];
  }
};

class Statistics {
 public:
  std::map<std::string, double> values;  ///< counts stay below 2^53

  void add(const std::string& name, std::uint64_t value) { values[name] += static_cast<double>(value); }
  void most(const std::string& name, std::uint64_t value) {
    values[name] = std::max(values[name], static_cast<double>(value));
  }
  void add(const std::string& name, const Distribution& d) {
    add(name + ".count", d.count);
    add(name + ".sum", d.sum);
    most(name + "_max", d.most);
    for (const auto& [bin, count] : d.bins) add(name + ".histogram.from_" + std::to_string(bin), count);
  }
  /// Turns sum and count of a distribution, of all units, into its mean.
  void finish_mean(const std::string& name) {
    values[name] = ratio(values[name + ".sum"], values[name + ".count"]);
    values.erase(name + ".sum");
    values.erase(name + ".count");
  }
  double operator[](const std::string& name) const {
    const auto found = values.find(name);
    return found == values.end() ? 0 : found->second;
  }
  static double ratio(double a, double b) { return b == 0 ? 0 : a / b; }
};

}  // namespace grtx::sim::plain
