// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/statistics_reference.h"

#include <fmt/format.h>

#include <regex>
#include <set>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {
namespace {

std::string group_of(const std::string& name) { return name.substr(0, name.find('.', name.find('.') + 1)); }

/// Turns the description of one row into that of all rows of its kind.
std::string generic_description(std::string description) {
  static const std::regex bin(" of 0 to 0 cycles$");
  static const std::regex largest("^(largest lower bound): .*");
  description = std::regex_replace(description, bin, " of n to 2n - 1 cycles; n = 0: of none");
  return std::regex_replace(description, largest, "$1; the description names it");
}

}  // namespace

std::string statistic_kind(const std::string& name) {
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
        {std::regex(R"(^(gpu\.l[12])\.()" + regions + R"()\.)"), "$1.<region>."}};
  }();
  std::string kind = name;
  for (const auto& [pattern, replacement] : rules) kind = std::regex_replace(kind, pattern, replacement);
  return kind;
}

modules::StatisticList statistic_kinds() {
  GpuCounters single_units;
  single_units.rt_of.resize(1);
  single_units.simt_of.resize(1);
  single_units.l1_of.resize(1);
  single_units.l2_of.resize(1);
  single_units.distributor.launches.resize(1);
  single_units.memory.statistics = modules::StatisticList::of_kinds();
  modules::describe(modules::DramCounters{}, std::vector<modules::DramChannelCounters>(1),
                    single_units.memory.statistics, "gpu.dram");
  auto kinds = modules::StatisticList::of_kinds();
  describe(single_units, kinds);
  describe(lower_bounds(single_units, {}, {}), 0, kinds);
  return kinds;
}

std::string statistics_reference(const modules::StatisticList& kinds) {
  std::string text;
  std::string group;
  std::set<std::string> listed;
  for (const modules::Statistic& s : kinds.items()) {
    const std::string name = statistic_kind(s.name);
    if (!listed.insert(name).second) continue;
    if (const std::string next_group = group_of(name); next_group != group) {
      group = next_group;
      text +=
          fmt::format("{}### {}\n\n| statistic | unit | meaning |\n|---|---|---|\n", text.empty() ? "" : "\n", group);
    }
    text += fmt::format("| `{}` | {} | {} |\n", name, s.unit, generic_description(s.description));
  }
  return text;
}

}  // namespace grtx::sim
