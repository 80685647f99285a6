// SPDX-License-Identifier: Apache-2.0
// Machines with the component's library alone: by name, by file, in an include; the same as by the program. Keys that
// contradict each other are refused whichever layers name them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "error_of.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "paths.h"
#include "shell.h"
#include "temporary_folder.h"

namespace grtx::sim {
namespace {

using grtx::test::error_of;
using ::testing::HasSubstr;

class MachineLayers : public ::testing::Test {
 protected:
  MachineLayers() { set_machines_folder(grtx::paths::source_dir() + "/configs/machines"); }
  const grtx::test::TemporaryFolder folder_;
};

// rt.memory.queue was 64 by load_config() and 256 by the program: 428,416 cycles for 425,262.
TEST_F(MachineLayers, GpuConfigIsTheMachinePaperInEveryKey) {
  EXPECT_EQ(config_json(load_config("paper", {})), config_json(GpuConfig()));
  EXPECT_EQ(config_json(load_machine({.machine = kDefaultMachine}).config), config_json(GpuConfig()));
  EXPECT_EQ(GpuConfig().rt.memory.queue, 256U);
}

// "unknown key 'tracer.child_order'": with grtx::sim alone nobody could put a machine on a board.
TEST_F(MachineLayers, EveryShippedMachineIsTheSameWithTheComponentAndWithTheProgram) {
  const std::vector<std::string> names = machine_names();
  ASSERT_THAT(names, ::testing::IsSupersetOf({"ada", "paper", "paper-charged", "paper-lean", "rdna4-share"}));
  for (const std::string& name : names) {
    const grtx::test::Outcome program = grtx::test::shell("'" + grtx::paths::program() + "' machine --json " + name);
    ASSERT_EQ(program.code, 0) << program.output;
    const nlohmann::json said = nlohmann::json::parse(program.output).at("keys");
    GpuConfig by_program;
    const std::vector<modules::Parameter> keys = config_keys(by_program);
    TracerTexts tracer = load_machine({.machine = name}).tracer;
    for (const auto& [key, entry] : said.items()) {
      const nlohmann::json& value = entry.at("value");
      const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
      if (key.starts_with("tracer.")) {
        EXPECT_EQ(tracer[key.substr(7)].value, text) << name << ": " << key;
        tracer.erase(key.substr(7));
      } else {
        apply_setting(key + "=" + text, keys);
      }
    }
    EXPECT_TRUE(tracer.empty()) << name;
    EXPECT_EQ(config_hash(load_config(name, {})), config_hash(by_program)) << name;
    EXPECT_EQ(config_hash(load_config(machine_file(name), {})), config_hash(by_program)) << name;
  }
}

TEST_F(MachineLayers, TracerOptionsComeBesideTheConfigurationWithTheirPlace) {
  const std::string own = folder_.write("own.toml", "[l1]\nlatency = 25\n[tracer]\nk = 16\nert = 0.02\n");
  EXPECT_EQ(load_config(own, {}).l1.latency, 25U);
  const TracerTexts tracer = load_machine({.machine = own}).tracer;
  EXPECT_EQ(tracer.at("k").value, "16");
  EXPECT_EQ(tracer.at("ert").value, "0.02");
  EXPECT_EQ(tracer.at("k").place.file, own);
  EXPECT_EQ(tracer.at("k").place.line, 4U);
  EXPECT_EQ(tracer.at("child_order").value, "slot") << "a machine is what differs from paper";
}

TEST_F(MachineLayers, AnIncludeTakesTheNameOfAMachine) {
  const std::string own = folder_.write("own.toml", "include = \"paper-charged\"\n[gpu]\nsms = 4\n");
  EXPECT_EQ(config_hash(load_config(own, {})), config_hash(load_config("paper-charged", {"gpu.sms=4"})));
  const std::string near = folder_.write("near.toml", "include = \"paper-chargd\"\n");
  EXPECT_THAT(error_of([&] { load_config(near, {}); }), HasSubstr("line 1: include: no file"));
  EXPECT_THAT(error_of([&] { load_config(near, {}); }), HasSubstr("the nearest is paper-charged"));
  folder_.write("paper-charged", "[gpu]\nsms = 3\n");  // a file beside it comes first, as ever
  EXPECT_EQ(load_config(folder_.write("file.toml", "include = \"paper-charged\"\n"), {}).sms, 3U);
}

// dram.bandwidth_gb_s in a file and dram.mhz by --set: the clock stayed, all latencies scaled (11,867 cycles for
// 4,567).
TEST_F(MachineLayers, AClockOverABandwidthIsRefused) {
  const std::string wide = folder_.write("wide.toml", "[dram]\nbandwidth_gb_s = 224.0\n");
  const std::string slow = folder_.write("slow.toml", "[dram]\nmhz = 875.0\n");
  const std::string wide_below = folder_.write("wide_below.toml", "include = 'wide.toml'\n[dram]\nmhz = 875.0\n");
  const std::string both_included = folder_.write("both.toml", "include = ['wide.toml', 'slow.toml']\n");
  const std::string quoted = folder_.write("quoted.toml", "'dram.mhz' = 875.0\n'dram.bandwidth_gb_s' = 224.0\n");
  const std::vector<ConfigSource> refused = {{.file = wide, .settings = {"dram.mhz=875"}},
                                             {.file = slow, .settings = {"dram.bandwidth_gb_s=224"}},
                                             {.machine = wide, .settings = {"dram.mhz=875"}},
                                             {.machine = slow, .settings = {"dram.bandwidth_gb_s=224"}},
                                             {.machine = wide, .file = slow},
                                             {.machine = slow, .file = wide},
                                             {.file = wide_below},
                                             {.file = both_included},
                                             {.file = quoted},
                                             {.settings = {"dram.mhz=875", "dram.bandwidth_gb_s=224"}},
                                             {.machine = "ada", .file = wide, .settings = {"dram.mhz=875"}}};
  for (std::size_t i = 0; i < refused.size(); ++i) {
    const std::string error = error_of([&] { load_machine(refused[i]); });
    EXPECT_THAT(error, HasSubstr("dram.bandwidth_gb_s and dram.mhz both set the memory clock: name one of them")) << i;
    EXPECT_EQ(error.find('\n'), error.npos) << i;
  }
  EXPECT_THAT(error_of([&] { load_machine(refused[0]); }), HasSubstr("--set: dram.mhz: "));
  EXPECT_THAT(error_of([&] { load_machine(refused[0]); }), HasSubstr("(dram.bandwidth_gb_s is that of " + wide));
}

TEST_F(MachineLayers, ABandwidthMayLieOverTheClockThatOneBeginsFrom) {
  const std::string own = folder_.write("own.toml", "include = 'ada'\n[dram]\nbandwidth_gb_s = 1200.0\n");
  const std::string slow = folder_.write("slow.toml", "[dram]\nmhz = 875.0\n");
  const std::string over = folder_.write("over.toml", "include = 'slow.toml'\n[dram]\nbandwidth_gb_s = 50.0\n");
  EXPECT_EQ(load_config(own, {}).dram_gb_s, 1200.0);
  EXPECT_EQ(load_config("ada", {"dram.bandwidth_gb_s=1200"}).dram_gb_s, 1200.0);
  EXPECT_EQ(load_machine({.machine = "ada", .file = own}).config.dram_gb_s, 1200.0);
  EXPECT_EQ(load_config(over, {}).memory_mhz, 875.0);
  // 0 says nothing: the clock is dram.mhz again.
  EXPECT_EQ(load_config(own, {"dram.bandwidth_gb_s=0", "dram.mhz=875"}).memory_mhz, 875.0);
}

TEST_F(MachineLayers, KeysOfADesignLieBelowSettingsAndAreCheckedWithThem) {
  const ConfigSource source{.machine = kDefaultMachine,
                            .design = "own",
                            .design_keys = {{"simt.registers_per_thread", "32"}, {"rt.any_hit_unit.enabled", "true"}},
                            .settings = {"simt.payload_registers=48", "rt.any_hit_unit.enabled=false"}};
  const LoadedConfig loaded = load_machine(source);
  EXPECT_EQ(loaded.config.simt.register_file.payload_registers, 48U);
  EXPECT_FALSE(loaded.config.rt.any_hit_unit.enabled);
  EXPECT_EQ(loaded.places.at("simt.registers_per_thread").file, "--design own");
  EXPECT_EQ(loaded.places.at("rt.any_hit_unit.enabled").file, "--set");
}

// A run read table1.toml 81 times: for each of three questions, once for each file that includes it.
TEST_F(MachineLayers, EachFileIsReadOnce) {
  const std::string own = folder_.write("own.toml", "include = ['ada-share', 'paper-charged']\n");
  LoadedConfig loaded = load_machine({.machine = "ada-share", .file = own, .settings = {"gpu.sms=4"}});
  EXPECT_THAT(loaded.files, ::testing::Contains(HasSubstr("table1.toml")));
  std::sort(loaded.files.begin(), loaded.files.end());
  EXPECT_EQ(std::adjacent_find(loaded.files.begin(), loaded.files.end()), loaded.files.end());
}

TEST_F(MachineLayers, KeysOfADesignDoNotChangeAMachine) {
  ConfigSource source{.machine = "ada-share", .design = "own", .design_keys = {{"simt.registers_per_thread", "32"}}};
  const LoadedConfig designed = load_machine(source);
  EXPECT_EQ(designed.machine_hash, config_hash(load_config("ada-share", {})));
  EXPECT_EQ(designed.undesigned_hash, designed.machine_hash);
  EXPECT_NE(config_hash(designed.config), designed.machine_hash);
  source.settings = {"gpu.sms=4"};
  EXPECT_EQ(load_machine(source).machine_hash, designed.machine_hash);
  EXPECT_EQ(load_machine(source).undesigned_hash, config_hash(load_config("ada-share", {"gpu.sms=4"})));
}

}  // namespace
}  // namespace grtx::sim
