// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/statistics_reference.h"

#include <fmt/format.h>

#include <map>
#include <regex>
#include <set>

#include "grtx/modules/cache/request_stages.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {
namespace {

std::string group_of(const std::string& name) { return name.substr(0, name.find('.', name.find('.') + 1)); }

/// " (`part` / `whole`)" where both are statistics.
std::string made_of(const modules::Statistic& s) {
  if (s.of.part_name.empty() || s.of.whole_name.empty()) return "";
  return fmt::format(" (`{}` / `{}`)", s.of.part_name, s.of.whole_name);
}

/// Turns the description of one row into that of all rows that it stands for.
std::string generic_description(std::string description) {
  static const std::regex bin(" of 0 to 0 cycles$");
  static const std::regex largest("^(largest lower bound): .*");
  description = std::regex_replace(description, bin, " of n to 2n - 1 cycles; n = 0: of none");
  static const std::regex kind("(reads?.*) for (nodes|leaves|shading|checkpoints|stacks)\\b");
  description = std::regex_replace(description, kind, "$1 of this kind");
  return std::regex_replace(description, largest, "$1; the description names it");
}

}  // namespace

std::string reference_name(const std::string& name) {
  static const std::vector<std::pair<std::regex, std::string>> rules = [] {
    std::string regions;
    for (const std::string& region : names_of<modules::Region>())
      regions += (regions.empty() ? "" : "|") + std::string(region);
    return std::vector<std::pair<std::regex, std::string>>{
        {std::regex(R"(^gpu\.sm\d+\.rt\d*\.)"), "gpu.sm<i>.rt<j>."},
        {std::regex(R"(^gpu\.sm\d+\.)"), "gpu.sm<i>."},
        {std::regex(R"(\.channel\d+\.)"), ".channel<i>."},
        {std::regex(R"(^gpu\.frame\d+\.)"), "gpu.frame<i>."},
        {std::regex(R"(\.from_\d+$)"), ".from_<n>"},
        {std::regex(R"(^gpu\.latency\.[a-z]+\.)"), "gpu.latency.<kind>."},
        {std::regex(R"(^(gpu\.l[12])\.()" + regions + R"()\.)"), "$1.<region>."}};
  }();
  std::string listed = name;
  for (const auto& [pattern, replacement] : rules) listed = std::regex_replace(listed, pattern, replacement);
  return listed;
}

bool is_of_one_part(const std::string& name) { return reference_name(name).find("<i>") != std::string::npos; }

modules::StatisticList all_statistics() {
  GpuCounters single_units;
  single_units.rt_of.resize(1);
  single_units.simt_of.resize(1);
  single_units.l1_of.resize(1);
  single_units.l2_of.resize(1);
  single_units.distributor.launches.resize(1);
  single_units.memory.statistics = modules::StatisticList::of_reference();
  modules::describe(modules::DramCounters{}, std::vector<modules::DramChannelCounters>(1),
                    single_units.memory.statistics, "gpu.dram");
  auto all = modules::StatisticList::of_reference();
  describe(single_units, all);
  describe(lower_bounds(single_units, {}, {}), 0, all);
  modules::RequestStages stages;
  for (std::size_t i = 0; i < modules::kRegionCount; ++i) stages.served(static_cast<modules::Region>(i), {}, 0);
  stages.describe(all);
  return all;
}

const modules::Statistic* declared_statistic(const std::string& name) {
  static const std::map<std::string, modules::Statistic> declared = [] {
    std::map<std::string, modules::Statistic> by_name;
    const modules::StatisticList all = all_statistics();
    for (const modules::Statistic& s : all.items()) by_name.emplace(reference_name(s.name), s);
    return by_name;
  }();
  const auto found = declared.find(reference_name(name));
  return found == declared.end() ? nullptr : &found->second;
}

std::string statistics_reference(const modules::StatisticList& all) {
  std::string text;
  std::string group;
  std::set<std::string> listed;
  for (const modules::Statistic& s : all.items()) {
    const std::string name = reference_name(s.name);
    if (!listed.insert(name).second) continue;
    if (const std::string next_group = group_of(name); next_group != group) {
      group = next_group;
      text += fmt::format("{}### {}\n\n| statistic | unit | kind | meaning |\n|---|---|---|---|\n",
                          text.empty() ? "" : "\n", group);
    }
    text += fmt::format("| `{}` | {} | {} | {}{} |\n", name, s.unit, name_of(s.kind),
                        generic_description(s.description), made_of(s));
  }
  return text;
}

}  // namespace grtx::sim
