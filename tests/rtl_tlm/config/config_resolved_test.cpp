// SPDX-License-Identifier: Apache-2.0
// The resolved configuration: the paper's values, a stable hash, and a reference that names every key.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

const std::string kConfigs = grtx::paths::source_dir() + "/configs/";

TEST(ConfigFiles, EachResolvesAndVariantsDifferFromThePaperInWhatTheySay) {
  const std::map<std::string, std::string> only = {{"intersection_only.toml", "rt.memory.by_shader"},
                                                   {"deep_stack.toml", "rt.warp_buffer.spill"}};
  const nlohmann::ordered_json paper = config_json(load_config(kConfigs + "table1.toml", {}));
  std::size_t variants = 0;
  for (const auto& file : std::filesystem::directory_iterator(kConfigs)) {
    if (file.path().extension() != ".toml") continue;  // plans of sweeps have a folder of their own
    const nlohmann::ordered_json found = config_json(load_config(file.path().string(), {}));
    const auto variant = only.find(file.path().filename().string());
    if (variant == only.end()) continue;
    ++variants;
    for (const auto& [key, value] : paper.items()) {
      EXPECT_EQ(found.at(key) != value, key == variant->second) << variant->first << ", " << key;
    }
  }
  EXPECT_EQ(variants, only.size());
}

TEST(PaperConfig, HasTheValuesOfTable1) {
  const nlohmann::ordered_json json = config_json(load_config(kConfigs + "table1.toml", {}));
  const std::vector<std::pair<const char*, double>> table = {
      {"gpu.sms", 8},         {"gpu.core_mhz", 1365}, {"rt.warp_buffer.entries", 8},
      {"simt.schedulers", 4}, {"l1.bytes", 131072},   {"l1.line_bytes", 128},
      {"l1.ways", 256},       {"l1.latency", 20},     {"l2.bytes", 4194304},
      {"l2.line_bytes", 128}, {"l2.ways", 16},        {"l2.latency", 165},
      {"dram.mhz", 3500}};
  for (const auto& [key, value] : table) EXPECT_EQ(json.at(key).get<double>(), value) << key;
}

TEST(PaperConfig, WithoutTheChargeAndWithAQueueForEveryLaneIsWhatTheProgramDefaultsTo) {
  EXPECT_EQ(
      config_json(load_config(kConfigs + "table1.toml", {"rt.checkpoint.traffic=uncharged", "rt.memory.queue=256"})),
      config_json(GpuConfig{}));
}

// By --config it started from the machine paper, by load_config() from Table I with every byte charged.
TEST(ConfigFiles, AFileStartsFromTheMachinePaperAsOnTheCommandLine) {
  const grtx::test::TemporaryFolder folder;
  folder.write("own.toml", "[l1]\nlatency = 25\n");
  GpuConfig expected;
  expected.l1.latency = 25;
  ASSERT_EQ(expected.rt.checkpoint.traffic, modules::TrafficCharging::uncharged);
  EXPECT_EQ(config_json(load_config(folder.path("own.toml"), {})), config_json(expected));
}

TEST(SmallConfig, DiffersFromThePaperOnlyInItsOwnKeys) {
  const nlohmann::ordered_json paper = config_json(load_config(kConfigs + "table1.toml", {}));
  const nlohmann::ordered_json small = config_json(load_config(kConfigs + "small.toml", {}));
  std::set<std::string> different;
  for (const auto& [key, value] : small.items()) {
    if (paper.at(key) != value) different.insert(key);
  }
  EXPECT_EQ(different, (std::set<std::string>{"gpu.sms", "gpu.resident_warps", "rt.warp_buffer.entries", "l1.bytes",
                                              "l1.ways", "l2.bytes", "l2.slices"}));
}

TEST(ConfigHash, DependsOnValuesOnly) {
  EXPECT_EQ(config_hash(load_config("", {"l1.latency=20"})), config_hash(GpuConfig{}));
  EXPECT_NE(config_hash(load_config("", {"l1.latency=21"})), config_hash(GpuConfig{}));
  EXPECT_EQ(config_hash(GpuConfig{}).size(), 16U);
}

TEST(ConfigKeys, AreUniqueDescribedAndHaveASource) {
  GpuConfig config;
  std::set<std::string> names;
  for (const modules::Parameter& key : config_keys(config)) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_FALSE(key.description.empty()) << key.name;
    EXPECT_STRNE(key.origin.source, "") << key.name;
    EXPECT_EQ(assign_text(key, value_text(key)), "") << key.name << ": the default must be allowed";
  }
}

TEST(ConfigKeys, EachReachesTheResolvedConfiguration) {
  GpuConfig reference;
  for (const modules::Parameter& probe : config_keys(reference)) {
    // Another allowed value for each kind of key.
    std::string other;
    if (const auto* names = std::get_if<modules::Choice>(&probe.value)) {
      if (names->names.size() == 1) continue;  // dram.model, until a program registers more
      other = names->names.back() == value_text(probe) ? names->names.front() : names->names.back();
    } else if (std::holds_alternative<bool*>(probe.value)) {
      other = value_text(probe) == "true" ? "false" : "true";
    } else if (probe.range.max < 1.0) {
      other = "0.5";
    } else {
      other = value_text(probe) == std::to_string(static_cast<std::uint64_t>(probe.range.min))
                  ? std::to_string(static_cast<std::uint64_t>(probe.range.min) + 1)
                  : std::to_string(static_cast<std::uint64_t>(probe.range.min));
    }
    GpuConfig changed;
    for (const modules::Parameter& key : config_keys(changed)) {
      if (key.name == probe.name) {
        EXPECT_EQ(assign_text(key, other), "") << key.name;
      }
    }
    EXPECT_NE(config_hash(changed), config_hash(reference)) << probe.name << " = " << other;
  }
}

}  // namespace
}  // namespace grtx::sim
