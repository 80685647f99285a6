// SPDX-License-Identifier: Apache-2.0
// simulate() with a memory from outside: statistics, conservation, waveform, timeline and watchdog work as with the
// built-in DRAM; dram.model names it.
#include "grtx/rtl_tlm/gpu/memory_system.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/memory_files.h"
#include "grtx/rtl_tlm/run/simulation_inputs.h"
#include "grtx/traces/reader.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/run/hostile_memory.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using ::testing::HasSubstr;

MemorySystemFactory hostile(const test::HostileBehaviour& behaviour) {
  return [behaviour](Gpu& gpu, const BuildOptions&) { return std::make_unique<test::HostileMemory>(gpu, behaviour); };
}

/// What the run throws, and stderr; "" when it ends.
std::string failure_of(const test::ObservedRun& run, const SimulationOptions& options) {
  ChildProcess child("simulation", [&]() -> std::string {
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
    ::testing::internal::CaptureStderr();
    try {
      simulate(run.path("t.grtx"), config, options);
    } catch (const Error& error) {
      return std::string("Error ") + error.what();
    } catch (const std::exception& error) {
      return std::string(error.what()) + "\n" + ::testing::internal::GetCapturedStderr();
    }
    return "";
  });
  return child.result();
}

ordered_json without_host(ordered_json stats) {
  for (auto it = stats.begin(); it != stats.end();)
    it = it.key().starts_with("host.") ? stats.erase(it) : std::next(it);
  return stats;
}

TEST(MemorySystem, AForeignMemoryKeepsConservationStatisticsWaveformAndTimeline) {
  const test::ObservedRun run;
  const ordered_json built_in = run.run({});
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SimulationOptions options;
    options.memory = hostile({.seed = seed});
    const ordered_json unseen = run.run(options);
    options.waveform.path = run.path("w.vcd");
    options.timeline.path = run.path("t.json");
    const ordered_json stats = run.run(options);  // fails for a violation, of the base protocol too
    EXPECT_EQ(without_host(stats), without_host(unseen)) << "watching changes nothing, and twice the same";
    // What a ray does never depends on time.
    for (const char* name : {"gpu.rt.node_visits", "gpu.rt.any_hit_calls"}) {
      EXPECT_EQ(test::statistic(stats, name), test::statistic(built_in, name)) << name;
    }
    EXPECT_GT(test::statistic(stats, "gpu.dram.reads"), 0U);
    EXPECT_EQ(test::statistic(stats, "gpu.dram.responses"),
              test::statistic(stats, "gpu.dram.reads") + test::statistic(stats, "gpu.dram.writes"));
    EXPECT_EQ(test::statistic(stats, "gpu.dram.bytes"), 32 * test::statistic(stats, "gpu.dram.responses"));
    EXPECT_EQ(test::statistic(stats, "gpu.dram.channel0.bytes") + test::statistic(stats, "gpu.dram.channel1.bytes"),
              test::statistic(stats, "gpu.dram.bytes"));
    EXPECT_GT(stats.at("gpu.dram.latency").at("value").get<double>(), 20.0);
    EXPECT_GT(test::statistic(stats, "gpu.dram.refreshes"), 0U);
    EXPECT_GT(stats.at("gpu.energy_nj.dram").at("value").get<double>(), 0.0);
    EXPECT_EQ(test::statistic(stats, "gpu.bound.dram_bandwidth"), 0U) << "it does not say how busy it was";
    const std::string waves = read_file(options.waveform.path);
    EXPECT_THAT(waves, HasSubstr("refreshes"));
    EXPECT_THAT(waves, HasSubstr("outstanding"));
    EXPECT_THAT(read_file(options.timeline.path), HasSubstr("dram.channel1"));
  }
}

TEST(MemorySystem, AForeignMemoryThatFallsSilentIsFoundByTheWatchdog) {
  const test::ObservedRun run;
  SimulationOptions options;
  options.memory = hostile({.silent_after = 20});
  options.watchdog_cycles = 100'000;
  const std::string text = failure_of(run, options);
  EXPECT_THAT(text, HasSubstr("deadlock in core cycle"));
  EXPECT_THAT(text, HasSubstr("memory_monitor0: "));  // its state is in the dump
  EXPECT_THAT(text, HasSubstr("gpu.l2_slice0: pipe"));
}

TEST(MemorySystem, AForeignMemoryThatLosesCountViolatesConservation) {
  /// Counts one read that nobody asked for.
  class Miscounting final : public MonitoredMemory {
   public:
    explicit Miscounting(Gpu& gpu) : MonitoredMemory(gpu, "miscounting") {
      for (unsigned i = 0; i < channels(); ++i) {
        targets_.push_back(
            std::make_unique<test::HostileTarget>(("target" + std::to_string(i)).c_str(), test::HostileBehaviour{}));
        socket(i).bind(targets_.back()->socket);
      }
    }
    MemoryTraffic traffic(unsigned channel) const override {
      MemoryTraffic traffic = MonitoredMemory::traffic(channel);
      if (channel == 1) ++traffic.reads;
      return traffic;
    }

   private:
    std::vector<std::unique_ptr<test::HostileTarget>> targets_;
  };
  const test::ObservedRun run;
  SimulationOptions options;
  options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<Miscounting>(gpu); };
  ChildProcess child("simulation", [&] {
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
    return nlohmann::json(simulate(run.path("t.grtx"), config, options).violations).dump();
  });
  const auto violations = nlohmann::json::parse(child.result()).get<std::vector<std::string>>();
  ASSERT_EQ(violations.size(), 1U) << nlohmann::json(violations).dump();
  EXPECT_THAT(violations[0], HasSubstr("DRAM reads: "));
}

TEST(MemorySystem, AnErrorResponseEndsInOneLineThatNamesSocketAndAddress) {
  const test::ObservedRun run;
  SimulationOptions options;
  options.memory = hostile({.bytes = 4096});
  const std::string text = failure_of(run, options);
  EXPECT_THAT(text, ::testing::StartsWith("Error memory: gpu.l2_slice"));
  EXPECT_THAT(text, ::testing::MatchesRegex(
                        ".*: address 0x[0-9a-f]+: the memory answered a (read|write) with TLM_ADDRESS_ERROR_RESPONSE"));
}

TEST(MemorySystem, DramModelTakesRegisteredNamesAndListsThem) {
  try {
    load_config("", {"dram.model=ramulatr"});
    FAIL() << "an unknown model was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("dram.model"));
    EXPECT_THAT(error.what(), HasSubstr("built_in"));
  }
  GpuConfig by_hand;
  by_hand.dram_model = "ramulatr";
  EXPECT_THROW(check_config(by_hand, "configuration"), Error);

  const test::ObservedRun run;
  ChildProcess child("simulation", [&] {
    register_memory_system("hostile", hostile({}));
    EXPECT_THROW(register_memory_system("hostile", hostile({})), std::logic_error);
    EXPECT_EQ(memory_system_names(), (std::vector<std::string>{"built_in", "hostile"}));
    const std::string small = grtx::paths::source_dir() + "/configs/small.toml";
    const GpuConfig config = load_config(small, {"dram.model=hostile"});
    EXPECT_NE(config_hash(config), config_hash(load_config(small, {})));
    return ::testing::Test::HasFailure() ? "failed" : simulate(run.path("t.grtx"), config, {}).document.dump();
  });
  const ordered_json document = ordered_json::parse(child.result());
  EXPECT_EQ(document.at("config").at("dram.model"), "hostile");
  EXPECT_TRUE(document.at("stats").contains("gpu.dram.refreshes"));
}

// The configuration has the name of its file alone: results of another memory were kept under the same key.
TEST(MemorySystem, AChangedFileOfTheMemoryChangesTheInputs) {
  const test::ObservedRun run;
  ChildProcess child("simulation", [&] {
    register_memory_system("hostile", hostile({}), true);
    const std::string file = run.path("memory.json"), part = run.path("memspec/part.json");
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml",
                                         {"dram.model=hostile", "dram.simulator.config=" + file});
    std::filesystem::create_directories(run.path("memspec"));
    write_file(file, R"({"memspec": "part.json", "of itself": "memory.json", "unknown": "none.json"})");
    write_file(part, "fast");
    const auto inputs = [&] { return simulate(run.path("t.grtx"), config, {}).document.at("inputs"); };
    const auto hash = [&] { return memory_files(config).hash(); };
    const std::string before = hash();
    EXPECT_EQ(memory_files(config).files().size(), 2U);
    EXPECT_EQ(inputs().at("memory.files_hash"), before);
    write_file(part, "slow");
    EXPECT_NE(hash(), before);
    write_file(part, "fast");
    EXPECT_EQ(hash(), before);
    write_file(run.path("memspec/none.json"), "now there");
    EXPECT_NE(hash(), before);
    EXPECT_TRUE(memory_files(GpuConfig()).files().empty());
    EXPECT_FALSE(simulation_inputs(traces::Reader(run.path("t.grtx")), GpuConfig()).contains("memory.files_hash"));
    return std::string(::testing::Test::HasFailure() ? "failed" : "held");
  });
  EXPECT_EQ(child.result(), "held");
}

}  // namespace
}  // namespace grtx::sim
