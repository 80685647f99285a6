// Keys without effect in a mode: the table names keys that exist, what it calls ignored is ignored, and what is set is
// named.
#include "grtx/rtl_tlm/gpu/mode_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/rtl/rtl_units.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using Names = std::vector<std::string_view>;

/// Another value of the key than its default.
std::string other_value(std::string_view key) {
  const auto value = config_json(GpuConfig{}).at(std::string(key));
  if (value.is_boolean()) return value.get<bool>() ? "false" : "true";
  if (key == "dram.scheduling") return "fcfs";
  if (key.ends_with(".implementation")) return "rtl";
  return std::to_string(value.get<std::uint64_t>() + 2);
}

std::string setting(std::string_view key) { return std::string(key) + "=" + other_value(key); }

nlohmann::ordered_json without_cost(const nlohmann::ordered_json& stats) {
  nlohmann::ordered_json rest = nlohmann::ordered_json::object();
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with("host.") && name.find("energy") == std::string::npos) rest[name] = entry;
  }
  return rest;
}

TEST(ModeKeys, TheTableNamesKeysThatExist) {
  GpuConfig config;
  const std::vector<modules::Parameter> keys = config_keys(config);
  for (const ModeKey& key : mode_keys()) {
    EXPECT_TRUE(std::any_of(keys.begin(), keys.end(), [&](const modules::Parameter& k) { return k.name == key.key; }))
        << key.key;
  }
}

TEST(ModeKeys, OnlyWhatIsSetIsNamed) {
  EXPECT_EQ(ignored_keys(load_config("", {}), {SimulationMode::fast}), Names{});
  const GpuConfig set = load_config("", {"dram.age_cap=7", "l1.mshr_merges=3", "l1.banks=8", "fast.seed=5"});
  EXPECT_EQ(ignored_keys(set, {SimulationMode::fast}), (Names{"l1.mshr_merges", "dram.age_cap"}));
  EXPECT_EQ(ignored_keys(set, {SimulationMode::cycle}), Names{"fast.seed"});
  EXPECT_EQ(ignored_keys(set, {SimulationMode::fast, SimulationMode::cycle}), Names{}) << "one of the two looks at it";
  EXPECT_EQ(ignored_keys(load_config("", {"l1.mshr_merges=8"}), {SimulationMode::fast}), Names{}) << "the default";
}

TEST(ModeKeys, TheLineNamesKeysAndMode) {
  testing::internal::CaptureStderr();
  warn_of_ignored_keys(load_config("", {"dram.age_cap=7", "l1.mshr_merges=3"}), {SimulationMode::fast}, "--mode fast");
  warn_of_ignored_keys(load_config("", {}), {SimulationMode::fast}, "--mode fast");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "grtx: configuration: l1.mshr_merges, dram.age_cap have no effect in --mode fast\n");
}

std::vector<std::string> idle(const std::vector<std::string>& settings) {
  std::vector<std::string> all;
  for (const IdleKey& each : idle_keys(load_config("", settings))) all.push_back(each.key + ": " + each.because);
  return all;
}

TEST(IdleKeys, AreThoseThatAnotherKeyLeavesWithoutEffect) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(idle({"dram.age_cap=7", "dram.banks=8", "dram.timing.rcd=9"}), Texts{});
  EXPECT_EQ(idle({"dram.hit_cap=2"}), Texts{"dram.hit_cap: dram.scheduling = fr_fcfs"});
  EXPECT_EQ(idle({"dram.hit_cap=2", "dram.scheduling=fr_fcfs_cap", "dram.age_cap=7"}), Texts{});
  EXPECT_EQ(idle({"dram.scheduling=fcfs", "dram.age_cap=7"}), Texts{"dram.age_cap: dram.scheduling = fcfs"});
  EXPECT_EQ(idle({"dram.group_bytes=64"}), Texts{"dram.group_bytes: dram.bank_groups = 1"});
  EXPECT_EQ(idle({"dram.group_bytes=64", "dram.bank_groups=2"}), Texts{});
  EXPECT_EQ(idle({"dram.timing.rfc=64"}), Texts{"dram.timing.rfc: dram.timing.refi = 0"});
  EXPECT_EQ(idle({"dram.timing.rfc=64", "dram.timing.refi=1000"}), Texts{});
}

TEST(IdleKeys, AWriteBackBufferNeedsWritesBack) {
  EXPECT_EQ(idle({"l1.write_back_buffer=4"}),
            std::vector<std::string>{"l1.write_back_buffer: l1.private_writes = write_through"});
  EXPECT_EQ(idle({"l1.write_back_buffer=4", "l1.private_writes=write_back"}), std::vector<std::string>{});
}

TEST(IdleKeys, OfTheBuiltInDramAreThoseThatASimulatorDoesNotAskFor) {
  register_memory_system("filed", nullptr, true);
  const std::vector<std::string> filed = {"dram.model=filed", "dram.simulator.config=a.json"};
  EXPECT_EQ(idle(filed), std::vector<std::string>{});
  std::vector<std::string> settings = filed;
  for (const char* used : {"dram.mhz=1000", "dram.fixed_latency=7", "l2.slices=2", "dram.channels=1"}) {
    settings.emplace_back(used);
  }
  EXPECT_EQ(idle(settings), std::vector<std::string>{});
  settings.emplace_back("dram.simulator.per_slice=false");
  EXPECT_EQ(idle(settings), std::vector<std::string>{"dram.channels: dram.simulator.per_slice = false"});
  GpuConfig config;
  for (const modules::Parameter& key : config_keys(config)) {
    if (!key.name.starts_with("dram.") || key.name.starts_with("dram.simulator.")) continue;
    if (key.name == "dram.model" || key.name == "dram.mhz" || key.name == "dram.fixed_latency" ||
        key.name == "dram.channels")
      continue;
    settings = filed;
    const bool any_value = key.name != "dram.timing.refi" && key.name != "dram.bank_groups";
    settings.push_back(any_value ? setting(key.name) : key.name + (key.name == "dram.bank_groups" ? "=4" : "=1000"));
    if (key.name == "dram.perfect") {
      EXPECT_THROW(load_config("", settings), Error) << "a limit study that is not made";
    } else {
      EXPECT_EQ(idle(settings), std::vector<std::string>{key.name + ": dram.model = filed"});
    }
  }
  EXPECT_EQ(idle({"dram.simulator.config=a.json"}),
            std::vector<std::string>{"dram.simulator.config: dram.model = built_in"});
  testing::internal::CaptureStderr();
  settings = filed;
  for (const char* idle : {"dram.banks=8", "dram.timing.cl=7", "l1.mshr_merges=3"}) settings.emplace_back(idle);
  warn_of_ignored_keys(load_config("", settings), {SimulationMode::fast}, "--mode fast");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "grtx: configuration: l1.mshr_merges has no effect in --mode fast\n"
            "grtx: configuration: dram.banks, dram.timing.cl have no effect with dram.model = filed\n");
}

TEST(ModeKeys, WhatIsRefusedIsRefusedByName) {
  for (const ModeKey& key : mode_keys()) {
    if (key.key.ends_with(".implementation") && !modules::has_rtl()) continue;  // refused before
    // The RTL of the checkpoint unit has requests alone.
    const GpuConfig config = load_config("", {"rt.checkpoint.traffic=charged", setting(key.key)});
    const Unmodelled lack = unmodelled(config, key.mode);
    EXPECT_EQ(lack.key, key.refused != nullptr ? key.key : "");
  }
}

TEST(ModeKeys, WhatFastModeIgnoresChangesNothingInIt) {
  const test::ObservedRun run(true, true);
  const auto plain = without_cost(run.run({}, {}, SimulationMode::fast));
  for (const ModeKey& key : mode_keys()) {
    if (key.mode != SimulationMode::fast || key.refused != nullptr) continue;
    EXPECT_EQ(without_cost(run.run({}, {setting(key.key)}, SimulationMode::fast)), plain) << key.key;
  }
  EXPECT_NE(without_cost(run.run({}, {"l1.latency=50"}, SimulationMode::fast)), plain) << "others do";
}

}  // namespace
}  // namespace grtx::sim
