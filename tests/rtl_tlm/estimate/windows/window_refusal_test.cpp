// SPDX-License-Identifier: Apache-2.0
// What windows mode refuses, in which words. Traces that it leaves to cycle mode: window_simulation_test.cpp.
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"

#include <gtest/gtest.h>

#include <string>

#include "error_of.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"

namespace grtx::sim {
namespace {

using test::error_of;

constexpr auto kCycle = SimulationMode::cycle;
constexpr auto kWindows = SimulationMode::windows;

TEST(WindowsRefuse, UnitsInSystemVerilogWhichRunWholeTracesOnly) {
  if (!has_rtl()) GTEST_SKIP() << "built without Verilator";
  for (const std::string key :
       {"rt.checkpoint.implementation", "rt.box.implementation", "rt.transform.implementation"}) {
    // The RTL of the checkpoint unit has requests alone.
    const GpuConfig config = load_config("", {"rt.checkpoint.traffic=charged", key + "=rtl"});
    EXPECT_FALSE(unmodelled(config, kCycle));
    EXPECT_EQ(unmodelled(config, kWindows).key, key);
  }
}

TEST(WindowsRefuse, MemorySystemsThatTheirIntervalsWereNotTriedWith) {
  GpuConfig config;
  config.dram_model = "of_a_user";
  EXPECT_NO_THROW(check_mode(config, kCycle));
  EXPECT_EQ(
      error_of([&] { check_mode(config, kWindows); }),
      "windows mode: dram.model: must be built_in with --mode windows: the windows' intervals were tried with it");
  EXPECT_NO_THROW(check_mode(GpuConfig(), kWindows));
}

TEST(WindowsRefuse, FilesForViewersAndWarmCaches) {
  const std::string viewers = "windows mode: has no waveforms, timelines or heat maps: use --mode cycle";
  const struct {
    void (*ask)(SimulationOptions&);
    bool heat_maps;
    std::string rule;
  } cases[] = {
      {[](SimulationOptions&) {}, false, ""},
      {[](SimulationOptions& o) { o.waveform.path = "a.vcd"; }, false, viewers},
      {[](SimulationOptions& o) { o.timeline.path = "a.json"; }, false, viewers},
      {[](SimulationOptions&) {}, true, viewers},
      {[](SimulationOptions& o) { o.warm_trace = "a.grtx"; }, false, "windows mode: --warm: needs --mode cycle"},
      {[](SimulationOptions& o) { o.warm_state = "a.state"; }, false, "windows mode: --warm-state: needs --mode cycle"},
      {[](SimulationOptions& o) { o.save_state = "a.state"; }, false, "windows mode: --save-state: needs --mode cycle"},
  };
  for (const auto& c : cases) {
    SimulationOptions options;
    c.ask(options);
    EXPECT_EQ(error_of([&] { check_mode(options, c.heat_maps, kWindows); }), c.rule);
    EXPECT_EQ(error_of([&] { check_mode(options, c.heat_maps, kCycle); }), "");
  }
}

TEST(WindowsRefuse, FramesThatFollowEachOther) {
  EXPECT_NO_THROW(check_mode_of_frames(kCycle));
  EXPECT_EQ(error_of([] { check_mode_of_frames(kWindows); }),
            "windows mode: --views: needs --mode cycle: windows keep no caches warm from frame to frame");
}

TEST(WindowsRefuse, OptionsOutOfRange) {
  const struct {
    double share, target_error;
    std::string rule;
  } cases[] = {
      {0.25, 0.0, ""},
      {1.0, 0.5, ""},
      {0.24, 0.0, "windows mode: --share: must be at least 0.25 and at most 1"},
      {1.1, 0.0, "windows mode: --share: must be at least 0.25 and at most 1"},
      {0.25, 1.0, "windows mode: --target-error: must be at least 0 and below 100%"},
      {0.25, -0.1, "windows mode: --target-error: must be at least 0 and below 100%"},
  };
  for (const auto& c : cases) {
    WindowOptions options;
    options.share = c.share;
    options.target_error = c.target_error;
    EXPECT_EQ(error_of([&] { check_windows(options); }), c.rule) << c.share << ", " << c.target_error;
  }
}

TEST(WindowsRefuse, SharesOfMoreThanHalfWhichTheWholeIsHardlySlowerThan) {
  EXPECT_EQ(reason_for_whole(kMostOfTrace), "");
  EXPECT_EQ(reason_for_whole(kMostOfTrace + 0.01), "to reach --target-error");
}

}  // namespace
}  // namespace grtx::sim
