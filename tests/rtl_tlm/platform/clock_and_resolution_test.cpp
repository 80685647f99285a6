// SPDX-License-Identifier: Apache-2.0
// A platform keeps its own time resolution, and a launch may begin at the edges of its clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "error_of.h"
#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "rtl_tlm/first_difference.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::Launcher;
using traces::testing::TemporaryFile;

/// Answers 80 ns later, by a call.
class SlowMemory final : public MonitoredMemory {
 public:
  explicit SlowMemory(Gpu& gpu) : MonitoredMemory(gpu, "slow", true), target_("target", gpu.dram.size()) {
    for (unsigned i = 0; i < channels(); ++i) {
      target_[i].register_b_transport(this, &SlowMemory::b_transport);
      socket(i).bind(target_[i]);
    }
  }

 private:
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    delay += sc_core::sc_time(80, sc_core::SC_NS);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
  }
  sc_core::sc_vector<tlm_utils::simple_target_socket<SlowMemory, 32>> target_;
};

GpuComponent::Options options_of(const std::string& trace, double core_mhz, double memory_mhz) {
  GpuComponent::Options options;
  options.machine.sms = 2;
  options.machine.core_mhz = core_mhz;
  options.machine.memory_mhz = memory_mhz;
  options.traces = {trace};
  return options;
}

struct Resolution {
  double value;
  sc_core::sc_time_unit unit;
};

/// Statistics of two launches and the waveform, or what is refused.
std::string launched(Resolution resolution, double core_mhz, double memory_mhz, bool slow_memory) {
  const TemporaryFile many("many"), waves("waves");
  test::write_tiny_trace(many.path(), {40, 32});
  ChildProcess child("platform", [&]() -> std::string {
    sc_core::sc_set_time_resolution(resolution.value, resolution.unit);
    GpuComponent::Options options = options_of(many.path(), core_mhz, memory_mhz);
    if (slow_memory) options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<SlowMemory>(gpu); };
    options.waveform.path = waves.path();
    std::string all;
    const std::string refused = grtx::test::error_of([&] {
      test::LaunchedGpu gpu("a", options, {{0}, {0, true, 7.0}});
      sc_core::sc_start();
      for (const SimulationResult& result : gpu.gpu.results()) all += test::statistics_of(result);
      for (const auto error : gpu.launcher.errors) all += "error " + std::to_string(error);
    });
    return refused + all;
  });
  const std::string printed = child.result();
  std::ifstream file(waves.path());
  return printed + std::string{std::istreambuf_iterator<char>(file), {}};
}

TEST(PlatformResolution, OneFemtosecondIsNotForcedOnThePlatform) {
  for (const bool slow_memory : {false, true}) {
    const std::string of_fs = launched({1, sc_core::SC_FS}, 1000.0, 2000.0, slow_memory);
    EXPECT_THAT(of_fs, ::testing::HasSubstr("error 0error 0")) << of_fs.substr(0, 500);
    EXPECT_THAT(of_fs, ::testing::HasSubstr("$enddefinitions"));
    for (const Resolution resolution : {Resolution{1, sc_core::SC_PS}, {100, sc_core::SC_PS}, {10, sc_core::SC_FS}}) {
      EXPECT_EQ(test::first_difference(launched(resolution, 1000.0, 2000.0, slow_memory), of_fs), "")
          << resolution.value << slow_memory;
    }
  }
}

TEST(PlatformResolution, AClockThatItDoesNotHaveIsNamedWithOneThatItHas) {
  EXPECT_THAT(
      launched({1, sc_core::SC_PS}, 1365.0, 2000.0, false),
      ::testing::HasSubstr("clock domain a.gpu.core_clock: the period of 1365 MHz, 732601 fs, is no multiple of "
                           "the time resolution, 1 ps"));
  EXPECT_THAT(launched({1, sc_core::SC_PS}, 1364.25648, 2000.0, false), ::testing::HasSubstr("error 0error 0"));
}

/// A GPU with a clock of the platform's, and what a test does with it in a thread.
struct ClockedBoard final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = ClockedBoard;
  using Script = std::function<void(ClockedBoard&)>;
  ClockedBoard(const std::string& trace, Script what)
      : sc_module("board"),
        gpu("gpu", options_of(trace, 1000.0, 2000.0)),
        launcher("launcher", {}),
        script(std::move(what)) {
    launcher.socket.bind(gpu.registers);
    launcher.interrupt.bind(line);
    gpu.interrupt.bind(line);
    gpu.clock.bind(clock);
    SC_THREAD(run);
  }
  void run() { script(*this); }
  void wait_ns(double ns) { wait(sc_core::sc_time(ns, sc_core::SC_NS)); }
  /// Waits until the launch has ended; the error register.
  std::uint32_t ended() {
    if (!line.read()) wait(line.posedge_event());
    const std::uint32_t error = launcher.read(GpuRegister::error);
    launcher.write(GpuRegister::control, ControlBits::kAcknowledge);
    wait(line.negedge_event());
    return error;
  }

  sc_core::sc_signal<bool> line{"line"}, clock{"clock"};
  GpuComponent gpu;
  Launcher launcher;
  Script script;
  nlohmann::json seen = nlohmann::json::array();
};

nlohmann::json on_a_clock(const ClockedBoard::Script& script) {
  const TemporaryFile many("many");
  test::write_tiny_trace(many.path(), {40, 32});
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_DO_NOTHING);
    ClockedBoard board(many.path(), script);
    sc_core::sc_start();
    nlohmann::json all = {board.seen, nlohmann::json::array()};
    for (const SimulationResult& result : board.gpu.results()) all[1].push_back(test::statistics_of(result));
    return all.dump();
  });
  return nlohmann::json::parse(child.result());
}

TEST(PlatformClock, ALaunchBeginsAtItsNextEdge) {
  const auto found = on_a_clock([](ClockedBoard& board) {
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(20000.0);  // the clock stands
    board.seen.push_back(board.launcher.read(GpuRegister::status));
    board.clock.write(true);
    board.seen.push_back(board.ended());
    const double first_ns = sc_core::sc_time_stamp().to_seconds() * 1e9;
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(50000.0);
    board.clock.write(false);
    board.wait_ns(5.0);
    board.clock.write(true);
    const double edge_ns = sc_core::sc_time_stamp().to_seconds() * 1e9;
    board.seen.push_back(board.ended());
    board.seen.push_back(sc_core::sc_time_stamp().to_seconds() * 1e9 - edge_ns - (first_ns - 20000.0));
  });
  EXPECT_EQ(found[0][0], StatusBits::kBusy);
  EXPECT_EQ(found[0][1], 0u);
  EXPECT_EQ(found[0][2], 0u);
  EXPECT_NEAR(found[0][3].get<double>(), 0.0, 1e-6) << "both took as long from their edges on";
  ASSERT_EQ(found[1].size(), 2u);
  EXPECT_EQ(found[1][0], found[1][1]);
}

TEST(PlatformClock, AStartThatWaitsForAnEdgeCanBeAbandoned) {
  const auto found = on_a_clock([](ClockedBoard& board) {
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(100.0);
    board.launcher.write(GpuRegister::control, ControlBits::kReset);
    board.seen.push_back(board.ended());
    board.clock.write(true);
    board.wait_ns(20000.0);
    board.seen.push_back(board.launcher.read(GpuRegister::launches));
    board.clock.write(false);
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(100.0);
    board.launcher.write(GpuRegister::control, ControlBits::kReset | ControlBits::kStart);
    board.wait_ns(100.0);
    board.seen.push_back(board.launcher.read(GpuRegister::status));
    board.clock.write(true);
    board.seen.push_back(board.ended());
  });
  EXPECT_EQ(found[0], nlohmann::json({static_cast<std::uint32_t>(LaunchError::aborted), 0u, StatusBits::kBusy, 0u}));
  EXPECT_EQ(found[1].size(), 1u);
}

}  // namespace
}  // namespace grtx::sim
