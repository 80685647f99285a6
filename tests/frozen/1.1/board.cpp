// SPDX-License-Identifier: Apache-2.0
// A board of somebody's: a bus, a memory with data, the GPU, and a processor that launches, aborts, resets, launches.
//   board TRACE.grtx
#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "grtx/rtl_tlm/platform/gpu_component.h"

namespace {

using namespace grtx::sim;

constexpr std::uint64_t kMemoryAt = 0x8000'0000, kGpuAt = 0x1000'0000;

/// Bytes by page; 60 ns.
struct Memory : sc_core::sc_module {
  explicit Memory(const sc_core::sc_module_name& name) : sc_module(name) {
    socket.register_b_transport(this, &Memory::b_transport);
    socket.register_transport_dbg(this, &Memory::transport_dbg);
  }
  void b_transport(tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    delay += sc_core::sc_time(60, sc_core::SC_NS);
    payload.set_response_status(transport_dbg(payload) != 0 ? tlm::TLM_OK_RESPONSE : tlm::TLM_ADDRESS_ERROR_RESPONSE);
  }
  unsigned transport_dbg(tlm::tlm_generic_payload& payload) {
    for (unsigned i = 0; i < payload.get_data_length(); ++i) {
      const std::uint64_t at = payload.get_address() + i;
      std::vector<unsigned char>& page = pages[at / 4096];
      page.resize(4096);
      if (payload.is_write()) page[at % 4096] = payload.get_data_ptr()[i];
      if (payload.is_read()) payload.get_data_ptr()[i] = page[at % 4096];
    }
    return payload.get_data_length();
  }
  tlm_utils::simple_target_socket<Memory> socket{"socket"};
  std::map<std::uint64_t, std::vector<unsigned char>> pages;
};

/// The processor's way to registers and memory.
struct Bus : sc_core::sc_module {
  explicit Bus(const sc_core::sc_module_name& name) : sc_module(name) {
    master.register_b_transport(this, &Bus::b_transport);
  }
  void b_transport(tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    const std::uint64_t address = payload.get_address();
    delay += sc_core::sc_time(10, sc_core::SC_NS);
    if (address >= kMemoryAt) {
      memory->b_transport(payload, delay);
    } else if (address >= kGpuAt && address < kGpuAt + kGpuRegisterBytes) {
      payload.set_address(address - kGpuAt);
      gpu->b_transport(payload, delay);
      payload.set_address(address);
    } else {
      payload.set_response_status(tlm::TLM_ADDRESS_ERROR_RESPONSE);
    }
  }
  tlm_utils::simple_target_socket<Bus> master{"master"};
  tlm_utils::simple_initiator_socket<Bus> memory{"memory"};
  tlm_utils::simple_initiator_socket<Bus, 32> gpu{"gpu"};
};

/// The GPU's channels, merged into one port of the memory; it has one of its own, beside the bus.
class Channels final : public MonitoredMemory {
 public:
  Channels(Gpu& gpu, Memory& memory)
      : MonitoredMemory(gpu, "board", true), memory_(memory), targets_("target", gpu.dram.size()) {
    for (unsigned i = 0; i < channels(); ++i) {
      targets_[i].register_b_transport(this, &Channels::b_transport);
      targets_[i].register_transport_dbg(this, &Channels::transport_dbg);
      socket(i).bind(targets_[i]);
    }
  }

 private:
  void b_transport(tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) { memory_.b_transport(payload, delay); }
  unsigned transport_dbg(tlm::tlm_generic_payload& payload) { return memory_.transport_dbg(payload); }
  Memory& memory_;
  sc_core::sc_vector<tlm_utils::simple_target_socket<Channels, 32>> targets_;
};

struct Processor : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Processor;
  explicit Processor(const sc_core::sc_module_name& name) : sc_module(name) { SC_THREAD(program); }

  std::uint32_t read(GpuRegister from) {
    std::uint32_t word = 0;
    transfer(tlm::TLM_READ_COMMAND, kGpuAt + static_cast<std::uint64_t>(from), word);
    return word;
  }
  void write(GpuRegister to, std::uint32_t word) {
    transfer(tlm::TLM_WRITE_COMMAND, kGpuAt + static_cast<std::uint64_t>(to), word);
  }
  void transfer(tlm::tlm_command command, std::uint64_t address, std::uint32_t& word) {
    tlm::tlm_generic_payload payload;
    payload.set_command(command);
    payload.set_address(address);
    payload.set_data_ptr(reinterpret_cast<unsigned char*>(&word));
    payload.set_data_length(sizeof word);
    payload.set_streaming_width(sizeof word);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    bus->b_transport(payload, delay);
    if (!payload.is_response_ok()) throw grtx::Error("board", "processor", payload.get_response_string());
    wait(delay);
  }
  LaunchError ended() {
    if (!interrupt.read()) wait(interrupt.posedge_event());
    const auto error = static_cast<LaunchError>(read(GpuRegister::error));
    write(GpuRegister::control, ControlBits::kAcknowledge);
    while (interrupt.read()) wait(interrupt.negedge_event());
    return error;
  }
  void launch() {
    write(GpuRegister::trace, 0);
    write(GpuRegister::control, ControlBits::kStart);
    const LaunchError error = ended();
    const bool done = (read(GpuRegister::status) & StatusBits::kDone) != 0;
    cycles.push_back(read(GpuRegister::cycles) | std::uint64_t{read(GpuRegister::cycles_high)} << 32);
    good = good && error == LaunchError::none && done;
  }
  void program() {
    launch();
    write(GpuRegister::control, ControlBits::kStart);
    wait(sc_core::sc_time(300, sc_core::SC_NS));
    write(GpuRegister::control, ControlBits::kReset);
    good = good && ended() == LaunchError::aborted;
    launch();
    write(GpuRegister::control, ControlBits::kStart);
    wait(sc_core::sc_time(300, sc_core::SC_NS));
    reset.write(true);
    wait(sc_core::sc_time(2, sc_core::SC_US));
    reset.write(false);
    wait(sc_core::sc_time(1, sc_core::SC_US));
    good = good && read(GpuRegister::launches) == 0;
    launch();
    ended_well = true;
  }

  tlm_utils::simple_initiator_socket<Processor> bus{"bus"};
  sc_core::sc_in<bool> interrupt{"interrupt"};
  sc_core::sc_out<bool> reset{"reset"};
  std::vector<std::uint64_t> cycles;
  bool good = true, ended_well = false;
};

int run(int argc, char** argv) {
  if (argc != 2) throw grtx::Error("board", "arguments", "TRACE.grtx");
  grtx::modules::set_time_resolution_to_fs();
  Memory memory("memory");
  Bus bus("bus");
  Processor processor("processor");
  GpuComponent::Options options;
  options.machine = load_config("", {"gpu.sms=2", "l2.slices=2"});
  options.traces = {argv[1]};
  options.base = kMemoryAt;
  options.keep_data = true;
  options.memory = [&memory](Gpu& gpu, const BuildOptions&) { return std::make_unique<Channels>(gpu, memory); };
  GpuComponent gpu("gpu", options);
  sc_core::sc_signal<bool> line("line"), reset("reset_line");
  processor.bus.bind(bus.master);
  bus.memory.bind(memory.socket);
  bus.gpu.bind(gpu.registers);
  gpu.interrupt.bind(line);
  gpu.reset.bind(reset);
  processor.interrupt.bind(line);
  processor.reset.bind(reset);
  sc_core::sc_start();
  const std::vector<std::uint64_t>& cycles = processor.cycles;
  for (const std::uint64_t launch : cycles) std::printf("%llu cycles\n", static_cast<unsigned long long>(launch));
  for (const SimulationResult& result : gpu.results()) {
    for (const std::string& violation : result.violations) std::printf("%s\n", violation.c_str());
  }
  const bool same = cycles.size() == 3 && cycles[0] == cycles[1] && cycles[1] == cycles[2] && cycles[0] > 0;
  return processor.good && processor.ended_well && same ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const grtx::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
