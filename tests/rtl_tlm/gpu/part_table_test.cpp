// SPDX-License-Identifier: Apache-2.0
// The table of the RT unit's parts names statistics, keys and stalls by strings: each must exist.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::sim {
namespace {

/// With and without each alternative.
std::vector<modules::PartInfo> all_rows() {
  std::vector<modules::PartInfo> rows;
  for (const bool other : {false, true}) {
    modules::RtUnitConfig config;
    config.traversal = other ? modules::TraversalWay::warp : modules::TraversalWay::lane;
    config.gaussian_unit = config.any_hit_unit.enabled = other;
    for (modules::PartInfo& row : modules::part_table(config, {})) rows.push_back(std::move(row));
  }
  return rows;
}

TEST(PartTable, NamesOnlyStatisticsThatRunsHave) {
  std::set<std::string> declared;
  const modules::StatisticList kinds = all_statistics();
  for (const modules::Statistic& statistic : kinds.items()) declared.insert(statistic.name);
  for (const modules::PartInfo& part : all_rows()) {
    for (const modules::EnergyAction& action : part.energy) {
      for (const std::string& name : action.statistics) EXPECT_TRUE(declared.contains(name)) << name;
    }
    for (const modules::PartBound& bound : part.bounds) {
      for (const std::string& name : bound.statistics) EXPECT_TRUE(declared.contains(name)) << name;
      EXPECT_TRUE(declared.contains("gpu.bound." + bound.name)) << bound.name;
      EXPECT_FALSE(bound.words.empty()) << bound.name;
    }
  }
}

TEST(PartTable, NamesOnlyKeysThatMachinesHave) {
  GpuConfig config;
  std::vector<std::string> keys;
  for (const modules::Parameter& parameter : config_keys(config)) keys.push_back(parameter.name);
  const auto is_key = [&](const std::string& prefix) {
    return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) { return key.starts_with(prefix); });
  };
  for (const modules::PartInfo& part : all_rows()) {
    for (const std::string& prefix : part.keys) EXPECT_TRUE(is_key(prefix)) << prefix;
    for (const modules::PartIdleKeys& idle : part.idle_keys) {
      EXPECT_TRUE(is_key(idle.key)) << idle.key;
      EXPECT_TRUE(is_key(idle.because.substr(0, idle.because.find(" = ")))) << idle.because;
    }
    if (part.pipelines) {
      EXPECT_TRUE(is_key(part.pipelines->count_key)) << part.pipelines->count_key;
    }
  }
}

TEST(PartTable, HasWordsForEachStallOnceAndEachTitleOnce) {
  std::multiset<std::string> words, titles;
  for (const modules::PartInfo& part : modules::part_table({}, {})) {
    for (const modules::StallWords& stall : part.stalls) words.insert(stall.stall);
    if (!part.title.empty()) titles.insert(part.title);
  }
  for (const std::string& stall : names_of<modules::Stall>()) EXPECT_EQ(words.count(stall), 1u) << stall;
  EXPECT_EQ(words.size(), modules::kStalls);
  for (const std::string& title : titles) EXPECT_EQ(titles.count(title), 1u) << title;
}

}  // namespace
}  // namespace grtx::sim
