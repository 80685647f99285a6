// SPDX-License-Identifier: Apache-2.0
// A launch that goes wrong on somebody else's platform ends with an error of its own, and the next one is as if it had
// never been: a hole in the bus, an abort, a reset in mid-launch, a start that was refused.
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "error_of.h"
#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::Launcher;
using traces::testing::TemporaryFile;

/// Addresses at which the memory answers; a test may move it.
struct AddressSpan {
  std::uint64_t first = 0, end = ~std::uint64_t{0};
  double busy_until_ns = 0.0;  ///< the memory says that something is under way until then
};

/// Answers after 100 ns; outside of the span with an error.
struct BusTarget final : sc_core::sc_module {
  BusTarget(const sc_core::sc_module_name& name, std::size_t ports, AddressSpan& span)
      : sc_module(name), sockets("socket", ports), span_(span) {
    for (auto& socket : sockets) socket.register_nb_transport_fw(this, &BusTarget::nb_transport_fw);
  }
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay) {
    if (phase != ::tlm::BEGIN_REQ) return ::tlm::TLM_ACCEPTED;
    const bool held = payload.get_address() >= span_.first && payload.get_address() < span_.end;
    payload.set_response_status(held ? ::tlm::TLM_OK_RESPONSE : ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
    delay += sc_core::sc_time(100, sc_core::SC_NS);
    return ::tlm::TLM_COMPLETED;
  }
  sc_core::sc_vector<tlm_utils::simple_target_socket<BusTarget, 32>> sockets;

 private:
  AddressSpan& span_;
};

class BusMemory final : public MonitoredMemory {
 public:
  BusMemory(Gpu& gpu, AddressSpan& span)
      : MonitoredMemory(gpu, "bus", true), target_("target", gpu.dram.size(), span), span_(span) {
    for (unsigned i = 0; i < channels(); ++i) socket(i).bind(target_.sockets[i]);
  }
  bool idle() const override {
    return MonitoredMemory::idle() && sc_core::sc_time_stamp() >= sc_core::sc_time(span_.busy_until_ns, sc_core::SC_NS);
  }

 private:
  BusTarget target_;
  AddressSpan& span_;
};

/// A GPU, its registers, its reset line, and what a test does with them in a thread.
struct Board final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Board;
  using Script = std::function<void(Board&)>;
  Board(const GpuComponent::Options& options, AddressSpan& memory, Script what)
      : sc_module("board"), span(memory), gpu("gpu", options), launcher("launcher", {}), script(std::move(what)) {
    launcher.socket.bind(gpu.registers);
    launcher.interrupt.bind(line);
    gpu.interrupt.bind(line);
    gpu.reset.bind(reset);
    SC_THREAD(run);
  }
  void run() { script(*this); }
  void wait_ns(double ns) { wait(sc_core::sc_time(ns, sc_core::SC_NS)); }
  std::uint32_t wait_for_interrupt() {
    if (!line.read()) wait(line.posedge_event());
    const std::uint32_t error = launcher.read(GpuRegister::error);
    launcher.write(GpuRegister::control, ControlBits::kAcknowledge);
    wait(line.negedge_event());
    return error;
  }
  std::uint64_t fault() {
    return launcher.read(GpuRegister::fault) | std::uint64_t{launcher.read(GpuRegister::fault_high)} << 32;
  }

  AddressSpan& span;
  sc_core::sc_signal<bool> line{"line"}, reset{"reset"};
  GpuComponent gpu;
  Launcher launcher;
  Script script;
  nlohmann::json seen = nlohmann::json::array();
};

std::string& last_warning() {
  static std::string text;
  return text;
}

/// What `script` has seen, and the statistics of the launches that ended.
nlohmann::json on_a_board(const Board::Script& script, AddressSpan span = {}, std::uint64_t base = 0) {
  const TemporaryFile many("many");
  test::write_tiny_trace(many.path(), {40, 32});
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    sc_core::sc_report_handler::set_handler([](const sc_core::sc_report& report, const sc_core::sc_actions& actions) {
      if (report.get_severity() == sc_core::SC_WARNING) {
        last_warning() = report.get_msg();
      } else {
        sc_core::sc_report_handler::default_handler(report, actions);
      }
    });
    GpuComponent::Options options;
    options.machine.sms = 2;
    options.traces = {many.path()};
    options.base = base;
    options.memory = [&span](Gpu& gpu, const BuildOptions&) { return std::make_unique<BusMemory>(gpu, span); };
    Board board(options, span, script);
    sc_core::sc_start();
    nlohmann::json all = {board.seen, nlohmann::json::array()};
    for (const SimulationResult& result : board.gpu.results()) {
      all[1].push_back(result.violations.empty() ? test::statistics_of(result) : result.violations.front());
    }
    return all.dump();
  });
  return nlohmann::json::parse(child.result());
}

constexpr auto code(LaunchError error) { return static_cast<std::uint32_t>(error); }

/// The statistics of a launch that nothing disturbs.
std::string undisturbed() {
  const auto found = on_a_board([](Board& board) { board.seen.push_back(board.launcher.launch({})); });
  EXPECT_EQ(found[0], nlohmann::json({0u}));
  return found[1].at(0);
}

TEST(LaunchFaults, ABusHoleIsAnErrorOfTheLaunch) {
  constexpr std::uint64_t kHole = 0x40;
  const auto found = on_a_board([](Board& board) {
    board.span.end = kHole;
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.fault());
    board.seen.push_back(board.launcher.read(GpuRegister::status));
    board.seen.push_back(last_warning());
    board.span = {};
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.fault());
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.launcher.read(GpuRegister::launches));
  });
  const auto& seen = found[0];
  EXPECT_EQ(seen[0], code(LaunchError::bus));
  EXPECT_GE(seen[1], kHole);
  EXPECT_EQ(seen[2], StatusBits::kError) << "it is over";
  EXPECT_NE(seen[3].get<std::string>().find("TLM_ADDRESS_ERROR_RESPONSE"), std::string::npos) << seen[3];
  EXPECT_EQ(seen[4], 0u);
  EXPECT_EQ(seen[5], 0u) << "the fault is of the launch before";
  EXPECT_EQ(seen[6], 0u);
  EXPECT_EQ(seen[7], 2u);
  EXPECT_EQ(found[1], nlohmann::json({undisturbed(), undisturbed()}));
}

TEST(LaunchFaults, ARunningLaunchCanBeAborted) {
  for (const double after_ns : {0.5, 300.0, 2000.0}) {
    const auto found = on_a_board([after_ns](Board& board) {
      board.launcher.write(GpuRegister::control, ControlBits::kStart);
      board.wait_ns(after_ns);
      board.launcher.write(GpuRegister::control, ControlBits::kReset);
      board.seen.push_back(board.wait_for_interrupt());
      board.seen.push_back(board.launcher.read(GpuRegister::status) & StatusBits::kBusy);
      board.seen.push_back(board.launcher.launch({}));
      board.seen.push_back(board.launcher.launch({}));
    });
    EXPECT_EQ(found[0], nlohmann::json({code(LaunchError::aborted), 0u, 0u, 0u})) << after_ns;
    EXPECT_EQ(found[1], nlohmann::json({undisturbed(), undisturbed()})) << after_ns;
  }
}

TEST(LaunchFaults, AnAbortThatStartsAnewBeginsAtOnce) {
  const auto found = on_a_board([](Board& board) {
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(500.0);
    board.seen.push_back(board.launcher.launch({.reset = true}));
    board.seen.push_back(board.launcher.launch({}));
  });
  EXPECT_EQ(found[0], nlohmann::json({0u, 0u}));
  ASSERT_EQ(found[1].size(), 2u);
  EXPECT_EQ(found[1][0], undisturbed());
  EXPECT_EQ(found[1][1], undisturbed());
}

TEST(LaunchFaults, AResetLineLeavesTheGpuAsBuilt) {
  const auto found = on_a_board([](Board& board) {
    board.seen.push_back(board.launcher.launch({}));
    board.launcher.write(GpuRegister::trace, 7);
    board.launcher.write(GpuRegister::control, ControlBits::kStart);  // refused: there is no trace 7
    board.wait_ns(1.0);
    board.seen.push_back(board.launcher.read(GpuRegister::error));
    board.launcher.write(GpuRegister::trace, 0);
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(500.0);
    board.reset.write(true);
    board.wait_ns(10.0);
    board.launcher.write(GpuRegister::control, ControlBits::kStart);  // not heard
    board.wait_ns(5000.0);
    for (std::uint64_t at = 4; at < kGpuRegisterBytes; at += 4) {
      const std::uint32_t word = board.launcher.read(static_cast<GpuRegister>(at));
      board.seen.push_back(at == static_cast<std::uint64_t>(GpuRegister::traces) ? word - 1 : word);
    }
    board.seen.push_back(board.line.read() ? 1u : 0u);
    board.reset.write(false);
    board.wait_ns(10.0);
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.launcher.read(GpuRegister::launches));
  });
  nlohmann::json wanted = {0u, code(LaunchError::no_such_trace)};
  for (std::uint64_t at = 4; at < kGpuRegisterBytes + 4; at += 4) wanted.push_back(0u);
  wanted.push_back(0u);
  wanted.push_back(0u);
  wanted.push_back(2u);
  EXPECT_EQ(found[0], wanted);
  EXPECT_EQ(found[1], nlohmann::json({undisturbed(), undisturbed(), undisturbed()}));
}

// The line fell before the memory had answered: the launch ended as if nothing had been.
TEST(LaunchFaults, AShortResetIsAReset) {
  const auto found = on_a_board([](Board& board) {
    board.span.busy_until_ns = 3220.0;
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(3030.0);  // the last warp ends 8 ns later
    board.reset.write(true);
    board.wait_ns(1.0);
    board.reset.write(false);
    board.wait_ns(10000.0);
    for (const auto at : {GpuRegister::status, GpuRegister::error, GpuRegister::launches}) {
      board.seen.push_back(board.launcher.read(at));
    }
    board.seen.push_back(board.line.read() ? 1u : 0u);
    board.seen.push_back(board.launcher.launch({}));
  });
  EXPECT_EQ(found[0], nlohmann::json({0u, 0u, 0u, 0u, 0u}));
  ASSERT_EQ(found[1].size(), 1u);
  EXPECT_EQ(found[1][0], undisturbed());
}

// All warps had ended, and the launch ended between the write and the annotated time: the new start was lost.
TEST(LaunchFaults, AnAbortAtTheVeryEndKeepsTheStartBesideIt) {
  for (double at_ns = 3000.0; at_ns < 3300.0; at_ns += 25.0) {
    const auto found = on_a_board([at_ns](Board& board) {
      board.span.busy_until_ns = 3220.0;
      board.launcher.write(GpuRegister::control, ControlBits::kStart);
      board.wait_ns(at_ns);
      board.launcher.write(GpuRegister::control, ControlBits::kStart | ControlBits::kReset | ControlBits::kAcknowledge,
                           150.0);
      board.wait_ns(10000.0);
      board.seen.push_back(board.launcher.read(GpuRegister::status));
    });
    EXPECT_EQ(found[0], nlohmann::json({StatusBits::kDone})) << at_ns;
    ASSERT_FALSE(found[1].empty()) << at_ns;
    EXPECT_EQ(found[1].back(), undisturbed()) << at_ns;
  }
}

TEST(LaunchFaults, TheErrorOfARefusedStartGoesWithAGoodEnd) {
  const auto found = on_a_board([](Board& board) {
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.wait_ns(100.0);
    board.launcher.write(GpuRegister::control, ControlBits::kStart);
    board.seen.push_back(board.wait_for_interrupt());
    board.seen.push_back(board.wait_for_interrupt());
    board.seen.push_back(board.launcher.read(GpuRegister::status));
  });
  EXPECT_EQ(found[0], nlohmann::json({code(LaunchError::busy), 0u, StatusBits::kDone}));
}

TEST(LaunchFaults, BytesOfRegistersAndDebugWrites) {
  const auto found = on_a_board([](Board& board) {
    unsigned char byte = 1;
    auto* const word = reinterpret_cast<std::uint32_t*>(&byte);
    board.seen.push_back(board.launcher.access(::tlm::TLM_WRITE_COMMAND, 0x09, word, 1));
    board.seen.push_back(board.launcher.read(GpuRegister::trace));
    byte = 0;
    board.seen.push_back(board.launcher.access(::tlm::TLM_WRITE_COMMAND, 0x09, word, 1));
    board.seen.push_back(board.launcher.access(::tlm::TLM_READ_COMMAND, 0x20, word, 1));
    board.seen.push_back(unsigned{byte});
    std::uint32_t start = ControlBits::kStart;
    ::tlm::tlm_generic_payload payload;
    payload.set_write();
    payload.set_address(0);
    payload.set_data_ptr(reinterpret_cast<unsigned char*>(&start));
    payload.set_data_length(4);
    payload.set_streaming_width(4);
    board.seen.push_back(board.launcher.socket->transport_dbg(payload));
    board.seen.push_back(board.wait_for_interrupt());
    board.seen.push_back(board.launcher.access(::tlm::TLM_READ_COMMAND, kGpuRegisterBytes - 1, &start, 2));
  });
  constexpr int kOk = ::tlm::TLM_OK_RESPONSE;
  EXPECT_EQ(found[0], nlohmann::json({kOk, 0x100u, kOk, kOk, 1u, 4u, 0u, int{::tlm::TLM_ADDRESS_ERROR_RESPONSE}}));
  EXPECT_EQ(found[1].at(0), undisturbed());
}

TEST(LaunchFaults, AMemoryMayBeginAnywhereOnTheBus) {
  constexpr std::uint64_t kBase = 0x1'8000'0000;
  const auto launch = [](Board& board) {
    board.seen.push_back(board.launcher.launch({}));
    board.seen.push_back(board.fault());
  };
  const auto there = on_a_board(launch, {kBase, kBase + 0x1000'0000}, kBase);
  EXPECT_EQ(there[0], nlohmann::json({0u, 0u}));
  EXPECT_EQ(there[1].at(0), undisturbed());
  const auto missed = on_a_board(launch, {0, kBase}, kBase);
  EXPECT_EQ(missed[0][0], code(LaunchError::bus));
  EXPECT_GE(missed[0][1], kBase);
}

TEST(LaunchFaults, ABaseThatNoMemoryHasIsRefused) {
  const TemporaryFile few("few");
  test::write_tiny_trace(few.path(), {3, 32});
  const auto refused = [&](std::uint64_t base) {
    ChildProcess child("platform", [&]() -> std::string {
      modules::set_time_resolution_to_fs();
      GpuComponent::Options options;
      options.traces = {few.path()};
      options.base = base;
      return grtx::test::error_of([&] { GpuComponent gpu("gpu", options); });
    });
    return child.result();
  };
  EXPECT_NE(refused(100).find("must be a multiple of 4096"), std::string::npos);
  EXPECT_NE(refused(8192).find("needs a memory"), std::string::npos);
}

}  // namespace
}  // namespace grtx::sim
