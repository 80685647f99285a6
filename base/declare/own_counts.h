// Counts of a unit that no table here knows: of somebody else, or one that not every machine has. It names each where
// it counts; units of one kind add up by name, and what is counted becomes a statistic like any other.
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
  /// name: behind the prefix of the statistics among which they appear, e.g. ray_box.waits. picojoules: energy of each
  /// that is counted; 0: priced by nobody, or with something else.
  void add(const std::string& name, std::uint64_t count, const std::string& unit, const std::string& description,
           double picojoules = 0.0) {
    const auto found = std::find_if(counts_.begin(), counts_.end(), [&](const Statistic& s) { return s.name == name; });
    if (found == counts_.end()) {
      counts_.push_back({name, count, unit, description, picojoules});
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
  /// 0 where nobody has counted it.
  std::uint64_t of(const std::string& name) const {
    const auto found = std::find_if(counts_.begin(), counts_.end(), [&](const Statistic& s) { return s.name == name; });
    return found == counts_.end() ? 0 : std::get<std::uint64_t>(found->value);
  }
  bool empty() const { return counts_.empty(); }

 private:
  std::vector<Statistic> counts_;  ///< integers
};

}  // namespace grtx::declare
