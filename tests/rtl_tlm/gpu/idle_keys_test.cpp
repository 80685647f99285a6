// SPDX-License-Identifier: Apache-2.0
// Keys that are set and have no effect are named, with what leaves them so.
#include "grtx/rtl_tlm/gpu/idle_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

/// Another value of the key than its default.
std::string other_value(std::string_view key) {
  const auto value = config_json(GpuConfig{}).at(std::string(key));
  if (value.is_boolean()) return value.get<bool>() ? "false" : "true";
  if (key == "dram.scheduling") return "fcfs";
  if (key.ends_with(".implementation")) return "rtl";
  return std::to_string(value.get<std::uint64_t>() + 2);
}

std::string setting(std::string_view key) { return std::string(key) + "=" + other_value(key); }

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
    if (key.name == "dram.perfect" || key.name == "dram.bandwidth_gb_s") {
      EXPECT_THROW(load_config("", settings), Error) << "of the built-in DRAM alone";
    } else {
      EXPECT_EQ(idle(settings), std::vector<std::string>{key.name + ": dram.model = filed"});
    }
  }
  EXPECT_EQ(idle({"dram.simulator.config=a.json"}),
            std::vector<std::string>{"dram.simulator.config: dram.model = built_in"});
  testing::internal::CaptureStderr();
  settings = filed;
  for (const char* idle : {"dram.banks=8", "dram.timing.cl=7"}) settings.emplace_back(idle);
  warn_of_idle_keys(load_config("", settings));
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "grtx: configuration: dram.banks, dram.timing.cl have no effect with dram.model = filed\n");
}

}  // namespace
}  // namespace grtx::sim
