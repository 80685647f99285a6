// What differs between the statistics of a run and those on record, by unit in the order in which data flow.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/regress/regression_case.h"

namespace grtx::sim {

/// The unit of the block diagram that a statistic belongs to: its place in the flow of data, and its name.
struct StatisticUnit {
  std::size_t place = 0;
  const char* name = "";
};
StatisticUnit unit_of_statistic(const std::string& statistic);

/// Whether a statistic says how long something took, not how much of it there was. unit: its unit.
bool is_time(const std::string& statistic, const std::string& unit);

struct StatisticDifference {
  std::string name;
  StatisticUnit unit;
  bool time = false;
  std::string recorded, found;  ///< as JSON; found is "" for what is missing
  double relative = 0.0;        ///< (found - recorded) / recorded; 0 without a number
};

struct StatisticsComparison {
  std::size_t compared = 0;
  std::vector<StatisticDifference> differences;  ///< by unit, then in the run's order
  std::vector<std::string> unrecorded;           ///< new statistics; no difference
  std::vector<std::string> configuration;        ///< keys that differ, "key: old -> new"; no difference by itself
  std::vector<std::string> inputs;               ///< of the inputs: trace_hash and the like
  bool equal() const { return differences.empty(); }
};

/// record, found: grtx.stats/1; of the record "config", "inputs" and the statistics' values are enough.
StatisticsComparison compare_statistics(const RegressionCase& regression_case, const nlohmann::ordered_json& record,
                                        const nlohmann::ordered_json& found);

/// What moved first: in the flow of data, the first unit that did more or less; where all units did as much as before,
/// the last that took longer or shorter, because waiting spreads against the flow. Where a key of the configuration
/// differs and its unit moved, it is that unit. nullptr when nothing differs.
const StatisticDifference* moved_first(const StatisticsComparison& comparison);

/// For people: at most `each` statistics a unit (0: all); without, those that moved most. Lines, indented.
std::string text_of(const StatisticsComparison& comparison, std::optional<std::size_t> each);

}  // namespace grtx::sim
