// SPDX-License-Identifier: Apache-2.0
// Differences between the statistics of a run and those on record, by unit in the order of the data flow.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/regress/regression_case.h"

namespace grtx::sim {

/// The unit of the block diagram that a statistic belongs to: its place in the data flow, and its name.
struct StatisticUnit {
  std::size_t place = 0;
  const char* name = "";
};
StatisticUnit unit_of_statistic(const std::string& statistic);

/// Whether a statistic is a time rather than an amount of work. unit: its unit.
bool is_time(const std::string& statistic, const std::string& unit);

struct StatisticDifference {
  std::string name;
  StatisticUnit unit;
  bool time = false;
  std::string recorded, found;  ///< as JSON; found is "" if the run lacks it
  double relative = 0.0;        ///< (found - recorded) / recorded; 0 without a number
};

struct StatisticsComparison {
  std::size_t compared = 0;
  std::vector<StatisticDifference> differences;  ///< by unit, then in the run's order
  std::vector<std::string> unrecorded;           ///< new statistics; do not count as differences
  std::vector<std::string> configuration;        ///< differing keys, "key: old -> new"; alone no difference
  std::vector<std::string> inputs;               ///< differing inputs (trace_hash, ...), in the same form
  std::string cycles;                            ///< gpu.cycles of the run, as JSON; "" if it is not compared
  bool equal() const { return differences.empty(); }
};

/// record, found: grtx.stats/1. The record needs only "config", "inputs" and the statistics' values.
StatisticsComparison compare_statistics(const RegressionCase& regression_case, const nlohmann::ordered_json& record,
                                        const nlohmann::ordered_json& found);

/// The likely origin of the differences: the first unit in the data flow whose work changed; if no work changed, the
/// last unit whose times changed, because waiting spreads against the flow. If a configuration key differs and its unit
/// changed, then that unit. nullptr when nothing differs.
const StatisticDifference* likely_origin(const StatisticsComparison& comparison);

/// Indented lines for people: at most `each` statistics per unit (0: all); without `each` those that changed most.
std::string text_of(const StatisticsComparison& comparison, std::optional<std::size_t> each);

}  // namespace grtx::sim
