// SPDX-License-Identifier: Apache-2.0
// A platform of two signals and a thread: launches what a test asks for on a GpuComponent and gathers the results.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <systemc>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/platform/gpu_component.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim::test {

struct TestLaunch {
  std::uint32_t trace = 0;
  bool keep_caches = false;
  double after_ns = 0.0;                                   ///< of the interrupt of the launch before
  bool reset = false;                                      ///< abandons a launch that stands still
  std::optional<std::uint32_t> then_trace = std::nullopt;  ///< written behind the start, before time passes
  bool one_transfer = false;                               ///< control, status and trace in a single write
};

/// Writes registers and waits for interrupts, a launch after the other.
class Launcher final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = Launcher;
  Launcher(const sc_core::sc_module_name& name, std::vector<TestLaunch> launches)
      : sc_module(name), socket("socket"), launches_(std::move(launches)) {
    SC_THREAD(run);
  }
  tlm_utils::simple_initiator_socket<Launcher, 32> socket;
  sc_core::sc_in<bool> interrupt{"interrupt"};

  std::uint32_t read(GpuRegister from) {
    std::uint32_t word = 0;
    require(access(tlm::TLM_READ_COMMAND, static_cast<std::uint64_t>(from), &word, 4) == ::tlm::TLM_OK_RESPONSE);
    return word;
  }
  void write(GpuRegister to, std::uint32_t word, double delay_ns = 0.0) {
    require(access(tlm::TLM_WRITE_COMMAND, static_cast<std::uint64_t>(to), &word, 4, delay_ns) ==
            ::tlm::TLM_OK_RESPONSE);
  }
  ::tlm::tlm_response_status access(::tlm::tlm_command command, std::uint64_t address, std::uint32_t* words,
                                    unsigned bytes, double delay_ns = 0.0) {
    ::tlm::tlm_generic_payload payload;
    payload.set_command(command);
    payload.set_address(address);
    payload.set_data_ptr(reinterpret_cast<unsigned char*>(words));
    payload.set_data_length(bytes);
    payload.set_streaming_width(bytes);
    sc_core::sc_time delay(delay_ns, sc_core::SC_NS);
    socket->b_transport(payload, delay);
    return payload.get_response_status();
  }
  /// Runs one launch; returns the error register.
  std::uint32_t launch(const TestLaunch& what) {
    const std::uint32_t control = ControlBits::kStart | (what.keep_caches ? ControlBits::kKeepCaches : 0u) |
                                  (what.reset ? ControlBits::kReset : 0u);
    if (what.one_transfer) {
      std::uint32_t words[] = {control, 0, what.trace};
      require(access(::tlm::TLM_WRITE_COMMAND, 0, words, sizeof words, what.after_ns) == ::tlm::TLM_OK_RESPONSE);
    } else {
      write(GpuRegister::trace, what.trace);
      write(GpuRegister::control, control, what.after_ns);
    }
    if (what.then_trace) write(GpuRegister::trace, *what.then_trace);
    require((read(GpuRegister::status) & StatusBits::kBusy) != 0);
    wait(interrupt.posedge_event());
    const std::uint32_t error = read(GpuRegister::error);
    write(GpuRegister::control, ControlBits::kAcknowledge);
    wait(interrupt.negedge_event());
    return error;
  }
  std::vector<std::uint32_t> errors;
  std::vector<std::uint64_t> cycles;  ///< as the registers say

 private:
  /// Thrown in a process: the kernel ends the simulation, and the test's child says so.
  static void require(bool holds) {
    if (!holds) throw std::runtime_error("a register does not answer as it should");
  }
  void run() {
    for (const TestLaunch& what : launches_) {
      errors.push_back(launch(what));
      cycles.push_back(read(GpuRegister::cycles) | std::uint64_t{read(GpuRegister::cycles_high)} << 32);
    }
  }
  std::vector<TestLaunch> launches_;
};

/// A GPU and who launches it.
struct LaunchedGpu {
  LaunchedGpu(const std::string& name, const GpuComponent::Options& options, const std::vector<TestLaunch>& launches)
      : gpu(name.c_str(), options), launcher((name + "_launcher").c_str(), launches) {
    launcher.socket.bind(gpu.registers);
    launcher.interrupt.bind(line);
    gpu.interrupt.bind(line);
  }
  sc_core::sc_signal<bool> line;
  GpuComponent gpu;
  Launcher launcher;
};

/// All statistics of a launch but those of the host, as text.
inline std::string statistics_of(const SimulationResult& result) {
  return statistics_object(result.statistics).dump(1);
}

}  // namespace grtx::sim::test
