// SPDX-License-Identifier: Apache-2.0
// The waveform of a run: read back, it shows the run; windows and scopes cut it; it never changes the result.
#include "grtx/rtl_tlm/observe/waveform.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/observe/vcd_reader.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

class WaveformTest : public ::testing::Test {
 protected:
  WaveformTest() { test::write_tiny_trace(trace_.path(), {4, 32}); }
  ~WaveformTest() override {
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(path_).parent_path())) {
      if (entry.path().string().starts_with(path_.substr(0, path_.size() - 4))) std::filesystem::remove(entry.path());
    }
  }

  /// Runs the tiny trace; returns its cycles.
  Cycle run(WaveformOptions options) {
    options.path = path_;
    SimulationOptions simulation;
    simulation.waveform = options;
    ChildProcess child("simulation", [&] {
      const SimulationResult result = test::simulate_priced(
          trace_.path(), load_config(grtx::paths::source_dir() + "/configs/small.toml", {}), simulation);
      return std::to_string(result.violations.empty() ? result.cycles : 0);
    });
    return std::stoull(child.result());
  }
  VcdFile read() const { return read_vcd(read_file(path_)); }

  traces::testing::TemporaryFile trace_{"waveform"};
  std::string path_ = ::testing::TempDir() + "grtx_waveform_" + std::to_string(::getpid()) + ".vcd";
};

constexpr std::uint64_t kCorePeriodFs = 732601;  // 1 / 1365 MHz

std::uint64_t largest(const std::vector<VcdFile::Change>& changes) {
  std::uint64_t value = 0;
  for (const auto& change : changes) value = std::max(value, change.value);
  return value;
}

TEST_F(WaveformTest, ShowsTheWholeRun) {
  const Cycle cycles = run({});
  ASSERT_GT(cycles, 0U);
  const VcdFile file = read();
  EXPECT_NE(file.comment.find("trace "), std::string::npos);
  EXPECT_NE(file.comment.find("config "), std::string::npos);
  EXPECT_GE(file.end, cycles * kCorePeriodFs);  // until write-backs and prefetches are done
  for (const char* name :
       {"gpu.cycle", "gpu.sm0.rt.warp_buffer.occupancy", "gpu.sm1.rt.warp_buffer.w3.state", "gpu.sm0.rt.ray_box.busy",
        "gpu.sm0.rt.rt_scheduler.stall_reason", "gpu.sm0.l1d.mshr", "gpu.l2_slice1.dram_outstanding",
        "gpu.dram.channel1.outstanding", "gpu.sm0.simt.slot3.activity", "gpu.sm1.rt_node_request.address"}) {
    ASSERT_TRUE(file.width.contains(name)) << name;
    EXPECT_FALSE(file.changes.at(name).empty()) << name;
  }
  // Four warps on two SMs: each SM holds two at once, works, and is empty at the end.
  EXPECT_EQ(largest(file.changes.at("gpu.sm0.rt.warp_buffer.occupancy")), 2U);
  EXPECT_EQ(file.changes.at("gpu.sm0.rt.warp_buffer.occupancy").back().value, 0U);
  EXPECT_GT(largest(file.changes.at("gpu.sm0.l1d.mshr")), 0U);
  EXPECT_EQ(largest(file.changes.at("gpu.sm0.rt.warp_buffer.w0.active")), 0xFFFFFFFFU);
  // No ray-sphere unit is elaborated for triangles.
  EXPECT_FALSE(file.width.contains("gpu.sm0.rt.ray_sphere.busy"));
}

TEST_F(WaveformTest, DoesNotChangeTheResult) {
  const Cycle with = run({});
  SimulationOptions options;
  ChildProcess child("simulation", [&] {
    return std::to_string(test::simulate_priced(trace_.path(),
                                                load_config(grtx::paths::source_dir() + "/configs/small.toml", {}),
                                                options)
                              .cycles);
  });
  EXPECT_EQ(std::stoull(child.result()), with);
}

TEST_F(WaveformTest, AWindowHoldsOnlyItsCycles) {
  WaveformOptions options;
  options.window = {300, 600};
  run(options);
  const VcdFile file = read();
  for (const auto& [name, changes] : file.changes) {
    for (const auto& change : changes) {
      EXPECT_GE(change.time, 300 * kCorePeriodFs) << name;
      EXPECT_LE(change.time, 600 * kCorePeriodFs) << name;
    }
  }
  EXPECT_EQ(file.end, 600 * kCorePeriodFs);
}

TEST_F(WaveformTest, AScopeSelectsSignalsByNameOrEnclosingScope) {
  for (const auto& [scope, prefix] :
       std::vector<std::pair<std::string, std::string>>{{"gpu.sm1.rt", "gpu.sm1.rt."},
                                                        {"gpu.sm?.l1d", "gpu.sm"},
                                                        {"gpu.cycle", "gpu.cycle"},
                                                        {"sm1.*", "gpu.sm1."},
                                                        {"l2_slice0,l2_slice1", "gpu.l2_slice"}}) {
    WaveformOptions options;
    options.scope = scope;
    run(options);
    const VcdFile file = read();
    EXPECT_FALSE(file.width.empty());
    for (const auto& [name, width] : file.width) EXPECT_TRUE(name.starts_with(prefix)) << scope << " gave " << name;
  }
}

TEST_F(WaveformTest, AScopeThatMatchesNothingIsAnError) {
  WaveformOptions options;
  options.scope = "cpu";
  EXPECT_THROW(run(options), Error);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(WaveformTest, UnitsAreFewerThanSignals) {
  WaveformOptions options;
  options.level = WaveLevel::units;
  run(options);
  const VcdFile file = read();
  EXPECT_TRUE(file.width.contains("gpu.sm0.rt.rt_scheduler.stall_reason"));
  for (const auto& [name, width] : file.width) {
    for (const char* detail : {"warp_buffer.w", "simt.slot", "request", "response", "trace_call"}) {
      EXPECT_EQ(name.find(detail), std::string::npos) << name;
    }
  }
}

TEST(WaveformWindow, IsParsed) {
  struct Case {
    const char* text;
    Cycle first, last;
  };
  for (const Case& c : {Case{"10:20", 10, 20}, Case{":20", 0, 20}, Case{"10:", 10, modules::kNever},
                        Case{":", 0, modules::kNever}, Case{"7:7", 7, 7}}) {
    const CycleWindow window = parse_window("--vcd-window", c.text);
    EXPECT_EQ(window.first, c.first) << c.text;
    EXPECT_EQ(window.last, c.last) << c.text;
  }
  for (const char* text : {"", "10", "20:10", "a:b", "1:2:3", "-1:3", "1 :3"}) {
    EXPECT_THROW(parse_window("--vcd-window", text), Error) << text;
  }
}

}  // namespace
}  // namespace grtx::sim
