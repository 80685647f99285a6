// SPDX-License-Identifier: Apache-2.0
// CciKeys: a platform's broker sets the machine's keys before the GPU is built.
#include <gtest/gtest.h>

#if __has_include(<cci_configuration>)
#include <cci_configuration>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/platform/cci_keys.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using cci::cci_value;
using Presets = std::vector<std::pair<std::string, cci_value>>;

/// A module of a platform, inside which the GPU and its keys are.
struct Board final : sc_core::sc_module {
  Board(const sc_core::sc_module_name& name, const GpuConfig& base, const std::string& trace)
      : sc_module(name), keys("gpu0", base), launched_gpu("gpu0", options(keys.machine(), trace), {{0}}) {}
  static GpuComponent::Options options(const GpuConfig& machine, const std::string& trace) {
    GpuComponent::Options options;
    options.machine = machine;
    options.traces = {trace};
    return options;
  }
  CciKeys keys;
  test::LaunchedGpu launched_gpu;
};

/// What `with(broker)` returns after the presets; an error's line where it throws.
template <typename F>
std::string preset(const Presets& presets, F&& with) {
  ChildProcess child("platform", [&]() -> std::string {
    modules::set_time_resolution_to_fs();
    cci_utils::broker global("global");
    cci::cci_register_broker(global);
    cci::cci_broker_handle broker = cci::cci_get_global_broker(cci::cci_originator("sc_main"));
    for (const auto& [name, value] : presets) broker.set_preset_cci_value(name, value);
    try {
      return with(broker);
    } catch (const Error& error) {
      return error.what();
    }
  });
  return child.result();
}

TEST(CciKeys, PresetsMakeTheMachineThatRuns) {
  const traces::testing::TemporaryFile trace("tiny");
  test::write_tiny_trace(trace.path(), {12, 32});
  GpuConfig base;
  base.sms = 3;
  const auto result =
      nlohmann::json::parse(preset({{"board.gpu0.rt.warp_buffer.entries", cci_value(2)},
                                    {"board.gpu0.gpu.sms", cci_value(std::uint64_t{1})},
                                    {"board.gpu0.gpu.core_mhz", cci_value(1000)},
                                    {"board.gpu0.dram.perfect", cci_value(true)},
                                    {"board.gpu0.l1.replacement", cci_value("fifo")},
                                    {"board.gpu1.gpu.sms", cci_value(7)}},
                                   [&](cci::cci_broker_handle broker) {
                                     Board board("board", base, trace.path());
                                     sc_core::sc_start();
                                     const auto handle = broker.get_param_handle("board.gpu0.rt.warp_buffer.entries");
                                     return nlohmann::json{{"machine", config_json(board.keys.machine())},
                                                           {"ran", config_json(board.launched_gpu.gpu.gpu().config())},
                                                           {"cycles", board.launched_gpu.launcher.cycles.at(0)},
                                                           {"of_cci", handle.get_cci_value().to_json()},
                                                           {"range", handle.get_metadata().has_entry("range")},
                                                           {"params", broker.get_param_handles().size()},
                                                           {"unused", broker.get_unconsumed_preset_values().size()}}
                                         .dump();
                                   }));
  GpuConfig same = load_config(
      base, "", "",
      {"rt.warp_buffer.entries=2", "gpu.sms=1", "gpu.core_mhz=1000", "dram.perfect=true", "l1.replacement=fifo"});
  EXPECT_EQ(result["machine"], nlohmann::json(config_json(same)));
  EXPECT_EQ(result["ran"], result["machine"]);
  EXPECT_EQ(result["of_cci"], "2");
  EXPECT_EQ(result["range"], true);
  EXPECT_EQ(result["params"], config_keys(same).size());
  EXPECT_EQ(result["unused"], 1) << "that of another GPU";
  ChildProcess alone("alone", [&] { return std::to_string(simulate(trace.path(), same, {}).cycles); });
  EXPECT_EQ(std::to_string(result["cycles"].get<std::uint64_t>()), alone.result());
}

struct Refused {
  std::string key;
  cci_value value;
  std::string line;
};

TEST(CciKeys, RefuseInOneLineThatNamesTheParameter) {
  const std::vector<Refused> cases = {
      {"gpu0.rt.warp_buffer.entries", cci_value(0), "must be 1 to"},
      {"gpu0.rt.warp_buffer.entries", cci_value(-1), "must be 1 to"},
      {"gpu0.rt.warp_buffer.entries", cci_value("8"), "must be an integer"},
      {"gpu0.rt.warp_buffer.entries", cci_value(8.5), "must be an integer"},
      {"gpu0.rt.warp_buffer.entries", cci_value(cci::cci_value_list()), "not []"},
      {"gpu0.dram.perfect", cci_value(1), "must be true or false"},
      {"gpu0.l1.replacement", cci_value("lr"), "lru"},
      {"gpu0.l1.replacement", cci_value(3), "not 3"},
      {"gpu0.gpu.rt_units", cci_value(16), ""},  // possible alone
      {"gpu0.rt.warp_bufer.entries", cci_value(4), "the nearest is 'rt.warp_buffer.entries'"},
      {"gpu0.gpu.smss", cci_value(4), "the nearest is 'gpu.sms'"},
      {"gpu0.gpu.sm0.rt.own_unit.delay", cci_value(4), ""},  // of a module
  };
  for (const Refused& bad : cases) {
    const std::string line = preset({{bad.key, bad.value}}, [](cci::cci_broker_handle broker) {
      CciKeys("gpu0", {}, broker);
      return std::string();
    });
    if (bad.line.empty()) {
      EXPECT_EQ(line, "") << bad.key;
    } else {
      EXPECT_TRUE(line.starts_with("CCI: " + bad.key + ": ")) << line;
      EXPECT_NE(line.find(bad.line), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
  EXPECT_TRUE(preset({{"gpu0.gpu.rt_units", cci_value(16)}, {"gpu0.gpu.resident_warps", cci_value(8)}},
                     [](cci::cci_broker_handle broker) {
                       CciKeys("gpu0", {}, broker);
                       return std::string();
                     })
                  .starts_with("CCI: gpu0.gpu.rt_units: must not be more than gpu.resident_warps"));
}

TEST(CciKeys, CannotBeChangedOnceTheGpuIsBuilt) {
  EXPECT_EQ(preset({},
                   [](cci::cci_broker_handle broker) {
                     const CciKeys keys("gpu0", {}, broker);
                     cci::cci_param_handle sms = broker.get_param_handle("gpu0.gpu.sms");
                     try {
                       sms.set_cci_value(cci_value(2));
                     } catch (const sc_core::sc_report& report) {
                       return std::string(report.get_msg_type());
                     }
                     return std::string("it was changed");
                   }),
            "/Accellera/CCI/SET_PARAM_FAILED");
}

}  // namespace
}  // namespace grtx::sim
#else
TEST(CciKeys, PresetsMakeTheMachineThatRuns) { GTEST_SKIP() << "CMake found no SystemCCCI"; }
#endif
