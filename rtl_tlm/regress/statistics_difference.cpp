// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/regress/statistics_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string_view>

#include "grtx/base/json.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

struct UnitNames {
  std::string unit;
  std::vector<std::string> prefixes;
  std::vector<std::string> keys;  ///< prefixes of its configuration keys
};

/// In the order of the data flow: a warp is launched, its rays traverse the tree, its fetches go to the DRAM. The
/// longest matching prefix decides a name's unit.
const std::vector<UnitNames>& units() {
  static const std::vector<UnitNames> all = [] {
    std::vector<UnitNames> list = {{"work distributor", {"gpu.distributor.", "gpu.sm", "gpu.frame"}, {"gpu."}},
                                   {"SIMT core", {"gpu.simt."}, {"simt."}}};
    for (const modules::PartInfo& part : modules::part_table({}, {})) {
      if (!part.title.empty()) list.push_back({part.title, part.statistics, part.keys});
    }
    list.insert(list.end(), {{"L1 data cache", {"gpu.l1."}, {"l1."}},
                             {"crossbar", {"gpu.crossbar."}, {"crossbar."}},
                             {"L2", {"gpu.l2."}, {"l2."}},
                             {"DRAM", {"gpu.dram."}, {"dram."}},
                             {"whole machine", {""}, {"gpu.core_mhz"}},
                             {"energy", {"gpu.energy_"}, {}},
                             {"lower bounds", {"gpu.bound."}, {}}});
    return list;
  }();
  return all;
}

/// Place of the unit with the longest prefix of `name`; none: no prefix fits.
std::optional<std::size_t> place_of(const std::string& name, std::vector<std::string> UnitNames::*prefixes) {
  std::optional<std::size_t> place;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < units().size(); ++i) {
    for (const std::string& prefix : units()[i].*prefixes) {
      if (!name.starts_with(prefix) || prefix.size() < longest) continue;
      longest = prefix.size();
      place = i;
    }
  }
  return place;
}

constexpr const char* kCycles = "gpu.cycles";  ///< asked for first, of any difference

/// Units whose configuration differs.
std::set<std::size_t> changed_units(const StatisticsComparison& comparison) {
  std::set<std::size_t> places;
  for (const std::string& line : comparison.configuration) {
    if (const auto place = place_of(line.substr(0, line.find(':')), &UnitNames::keys)) places.insert(*place);
  }
  return places;
}

/// Whether these are statistics of the whole machine, energy or bounds, which follow from the units.
bool is_derived(const StatisticUnit& unit) {
  static const std::size_t whole_machine = unit_of_statistic("gpu.cycles").place;
  return unit.place >= whole_machine;
}

std::string text_of_value(const ordered_json& statistic) { return json_text(statistic.at("value")); }

void compare_objects(const ordered_json& record, const ordered_json& found, const char* part,
                     std::vector<std::string>& lines) {
  const ordered_json none = ordered_json::object();
  const ordered_json& old_values = record.contains(part) ? record.at(part) : none;
  const ordered_json& new_values = found.contains(part) ? found.at(part) : none;
  for (const auto& [key, value] : new_values.items()) {
    const auto old = old_values.find(key);
    if (old == old_values.end()) {
      lines.push_back(fmt::format("{}: new, {}", key, json_text(value)));
    } else if (*old != value) {
      lines.push_back(fmt::format("{}: {} -> {}", key, json_text(*old), json_text(value)));
    }
  }
  for (const auto& [key, value] : old_values.items()) {
    if (!new_values.contains(key)) lines.push_back(fmt::format("{}: {}, is gone", key, json_text(value)));
  }
}

std::string line_of(const StatisticDifference& difference) {
  if (difference.found.empty()) return fmt::format("{} {} -> missing", difference.name, difference.recorded);
  const std::string change = difference.relative == 0.0 ? "" : fmt::format(" ({:+.3g} %)", 100.0 * difference.relative);
  return fmt::format("{} {} -> {}{}", difference.name, difference.recorded, difference.found, change);
}

}  // namespace

StatisticUnit unit_of_statistic(const std::string& statistic) {
  if (statistic.starts_with("gpu.sm") && statistic.find(".rt") != statistic.npos) return unit_of_statistic("gpu.rt.");
  const std::size_t place = *place_of(statistic, &UnitNames::prefixes);  // "" fits all
  return {place, units()[place].unit.c_str()};
}

bool is_time(const std::string& statistic, const std::string& unit) {
  const modules::Statistic* const declared = declared_statistic(statistic);
  if (declared != nullptr && declared->kind == modules::StatisticKind::histogram) return true;  // each is of latencies
  const std::string& of = unit.empty() && declared != nullptr ? declared->unit : unit;
  return of.find("cycle") != of.npos || of.find("clock") != of.npos || of == "us" || of == "ns";
}

StatisticsComparison compare_statistics(const RegressionCase& regression_case, const ordered_json& record,
                                        const ordered_json& found) {
  StatisticsComparison comparison;
  const ordered_json& recorded = record.at("stats");
  const ordered_json& stats = found.at("stats");
  for (const auto& [name, now] : stats.items()) {
    const auto statistic = recorded.find(name);
    if (!is_compared(regression_case, name) || statistic == recorded.end()) continue;
    ++comparison.compared;
    if (name == kCycles) comparison.cycles = text_of_value(now);
    const ordered_json &old_value = statistic->at("value"), &new_value = now.at("value");
    if (old_value == new_value) continue;
    StatisticDifference difference{name,
                                   unit_of_statistic(name),
                                   is_time(name, now.value("unit", "")),
                                   text_of_value(*statistic),
                                   text_of_value(now),
                                   0.0};
    if (old_value.is_number() && new_value.is_number()) {
      const double before = old_value.get<double>(), change = new_value.get<double>() - before;
      if (std::abs(change) <= tolerance_of(regression_case, name) * std::abs(before)) continue;
      difference.relative = before == 0.0 ? 0.0 : change / before;
    }
    comparison.differences.push_back(std::move(difference));
  }
  for (const auto& [name, statistic] : recorded.items()) {
    if (!is_compared(regression_case, name) || stats.contains(name)) continue;
    ++comparison.compared;
    comparison.differences.push_back(
        {name, unit_of_statistic(name), is_time(name, ""), text_of_value(statistic), "", 0.0});
  }
  std::stable_sort(comparison.differences.begin(), comparison.differences.end(),
                   [](const auto& a, const auto& b) { return a.unit.place < b.unit.place; });
  for (const auto& [name, statistic] : stats.items()) {
    if (is_compared(regression_case, name) && !recorded.contains(name)) comparison.unrecorded.push_back(name);
  }
  compare_objects(record, found, "config", comparison.configuration);
  compare_objects(record, found, "inputs", comparison.inputs);
  return comparison;
}

const StatisticDifference* likely_origin(const StatisticsComparison& comparison) {
  // If a key differs, the cause is in its unit, whatever else changed.
  std::set<std::size_t> changed = changed_units(comparison);
  const auto is_in_changed_unit = [&](const StatisticDifference& d) { return changed.contains(d.unit.place); };
  const auto& all = comparison.differences;
  if (std::none_of(all.begin(), all.end(), is_in_changed_unit)) changed.clear();
  const StatisticDifference* work = nullptr;
  const StatisticDifference* time = nullptr;
  const StatisticDifference* sum = nullptr;
  for (const StatisticDifference& difference : all) {
    if (!changed.empty() && !is_in_changed_unit(difference)) continue;
    if (is_derived(difference.unit)) {
      if (sum == nullptr) sum = &difference;
    } else if (!difference.time) {
      if (work == nullptr) work = &difference;
    } else if (time == nullptr || difference.unit.place > time->unit.place) {
      time = &difference;
    }
  }
  return work != nullptr ? work : time != nullptr ? time : sum;
}

namespace {

constexpr std::size_t kLargestChanges = 8;

/// By unit, at most `each` per unit (0: all).
std::string by_unit(const std::vector<StatisticDifference>& all, std::size_t each) {
  std::string text;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].unit.place == all[begin].unit.place) ++end;
    text += fmt::format("  {}: {} differ\n", all[begin].unit.name, end - begin);
    const std::size_t shown = each == 0 ? end : std::min(end, begin + each);
    for (std::size_t i = begin; i < shown; ++i) text += fmt::format("    {}\n", line_of(all[i]));
    if (shown < end) text += fmt::format("    and {} more\n", end - shown);
  }
  return text;
}

/// Those that changed most, and how many differ in each unit.
std::string largest_changes(const std::vector<StatisticDifference>& all) {
  std::vector<const StatisticDifference*> order;
  for (const StatisticDifference& difference : all) order.push_back(&difference);
  // A statistic that is missing or was 0 has no relative change: it sorts first.
  const auto share = [](const StatisticDifference& d) {
    return d.relative == 0.0 ? std::numeric_limits<double>::infinity() : std::abs(d.relative);
  };
  std::stable_sort(order.begin(), order.end(), [&](const auto* a, const auto* b) { return share(*a) > share(*b); });
  order.resize(std::min(order.size(), kLargestChanges));
  std::string text = order.empty() ? "" : "  moved most:\n";
  for (const StatisticDifference* difference : order) text += fmt::format("    {}\n", line_of(*difference));
  std::string counts;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].unit.place == all[begin].unit.place) ++end;
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", all[begin].unit.name, end - begin);
  }
  if (all.size() > kLargestChanges) text += fmt::format("  differ: {} (--each 0 prints all)\n", counts);
  return text;
}

}  // namespace

std::string text_of(const StatisticsComparison& comparison, std::optional<std::size_t> each) {
  std::string text;
  const auto cycles = std::ranges::find(comparison.differences, kCycles, &StatisticDifference::name);
  if (cycles != comparison.differences.end()) {
    text += fmt::format("  {}\n", line_of(*cycles));
  } else if (!comparison.cycles.empty() && !comparison.equal()) {
    text += fmt::format("  {} {}, as on record\n", kCycles, comparison.cycles);
  }
  for (const std::string& input : comparison.inputs) text += fmt::format("  input {}\n", input);
  for (const std::string& key : comparison.configuration) text += fmt::format("  configuration {}\n", key);
  if (const StatisticDifference* first = likely_origin(comparison)) {
    text += fmt::format("  moved first: {}: {}\n", first->unit.name, line_of(*first));
  }
  return text + (each ? by_unit(comparison.differences, *each) : largest_changes(comparison.differences));
}

}  // namespace grtx::sim
