// SPDX-License-Identifier: Apache-2.0
// Counters of a unit without a CounterTable here: user-supplied, or not in every machine. The unit names each counter
// when it counts; units are combined by name, and each counter becomes a statistic like any other.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "grtx/base/declare/statistics.h"

namespace grtx::declare {

class OwnCounts {
 public:
  /// Adds `count` to counter `name`, e.g. ray_box.waits, to which the enclosing statistics' prefix is added.
  /// picojoules: energy per count; 0: none, or accounted for elsewhere.
  void add(const std::string& name, std::uint64_t count, const std::string& unit, const std::string& description,
           double picojoules = 0.0) {
    const auto found = std::find_if(counts_.begin(), counts_.end(), [&](const Statistic& s) { return s.name == name; });
    if (found == counts_.end()) {
      counts_.push_back({name, count, unit, description, picojoules, StatisticKind::count});
    } else {
      std::get<std::uint64_t>(found->value) += count;
    }
  }
  void add(const OwnCounts& other) {
    for (const Statistic& s : other.counts_) {
      add(s.name, std::get<std::uint64_t>(s.value), s.unit, s.description, s.picojoules);
    }
  }
  void describe(StatisticList& list, const std::string& prefix) const {
    for (Statistic s : counts_) {
      s.name = prefix + "." + s.name;
      list.add(std::move(s));
    }
  }
  /// Value of a counter; 0 if it was never counted.
  std::uint64_t of(const std::string& name) const {
    const auto found = std::find_if(counts_.begin(), counts_.end(), [&](const Statistic& s) { return s.name == name; });
    return found == counts_.end() ? 0 : std::get<std::uint64_t>(found->value);
  }
  bool empty() const { return counts_.empty(); }

 private:
  std::vector<Statistic> counts_;  ///< values are integers
};

}  // namespace grtx::declare
