// SPDX-License-Identifier: Apache-2.0
// A small virtual platform: a processor, a bus, a memory and two of our GPUs, each of which the processor launches
// twice. docs/guide/platform.md.
//   platform MACHINE A.grtx B.grtx
// The traces are of one design. Each line gives the cycles of a launch: those of `grtx sim` with the same file.
#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/rtl_tlm/platform/gpu_component.h"

namespace {

using grtx::sim::ControlBits;
using grtx::sim::GpuComponent;
using grtx::sim::GpuRegister;
using grtx::sim::StatusBits;

constexpr std::uint64_t kMemory = 0x0000'0000, kGpu = 0x1000'0000, kGpuStride = 0x1000;
constexpr std::size_t kGpus = 2, kLaunches = 2;

/// One master; slaves by address. Each transfer takes 10 ns.
class Bus final : public sc_core::sc_module {
 public:
  explicit Bus(const sc_core::sc_module_name& name) : sc_module(name) {
    master.register_b_transport(this, &Bus::b_transport);
    master.register_transport_dbg(this, &Bus::transport_dbg);
  }
  tlm_utils::simple_target_socket<Bus> master{"master"};
  tlm_utils::simple_initiator_socket<Bus> memory{"memory"};
  sc_core::sc_vector<tlm_utils::simple_initiator_socket<Bus>> gpu{"gpu", kGpus};

 private:
  /// The slave of an address, which becomes the address inside it; nullptr: there is none.
  tlm_utils::simple_initiator_socket<Bus>* decode(tlm::tlm_generic_payload& payload) {
    const std::uint64_t address = payload.get_address();
    if (address < kGpu) return &memory;
    const std::uint64_t number = (address - kGpu) / kGpuStride;
    if (number >= kGpus) return nullptr;
    payload.set_address((address - kGpu) % kGpuStride);
    return &gpu[number];
  }
  void b_transport(tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    const std::uint64_t address = payload.get_address();
    delay += sc_core::sc_time(10, sc_core::SC_NS);
    if (auto* const slave = decode(payload)) {
      (*slave)->b_transport(payload, delay);
    } else {
      payload.set_response_status(tlm::TLM_ADDRESS_ERROR_RESPONSE);
    }
    payload.set_address(address);
  }
  unsigned transport_dbg(tlm::tlm_generic_payload& payload) {
    auto* const slave = decode(payload);
    return slave == nullptr ? 0 : (*slave)->transport_dbg(payload);
  }
};

/// 4 KiB, 30 ns per access.
class Memory final : public sc_core::sc_module {
 public:
  explicit Memory(const sc_core::sc_module_name& name) : sc_module(name) {
    socket.register_b_transport(this, &Memory::b_transport);
    socket.register_transport_dbg(this, &Memory::transport_dbg);
  }
  tlm_utils::simple_target_socket<Memory> socket{"socket"};

 private:
  void b_transport(tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    delay += sc_core::sc_time(30, sc_core::SC_NS);
    payload.set_response_status(transport_dbg(payload) != 0 ? tlm::TLM_OK_RESPONSE : tlm::TLM_ADDRESS_ERROR_RESPONSE);
  }
  unsigned transport_dbg(tlm::tlm_generic_payload& payload) {
    const unsigned bytes = payload.get_data_length();
    if (payload.get_address() > bytes_.size() || bytes > bytes_.size() - payload.get_address()) return 0;
    unsigned char* const here = bytes_.data() + payload.get_address();
    if (payload.is_read()) std::memcpy(payload.get_data_ptr(), here, bytes);
    if (payload.is_write()) std::memcpy(here, payload.get_data_ptr(), bytes);
    return bytes;
  }
  std::array<unsigned char, 4096> bytes_{};
};

/// Its program: in each round it starts all GPUs with the traces that a list in the memory names, sleeps until all have
/// raised their interrupts, and writes the cycles into the list.
class Processor final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = Processor;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  explicit Processor(const sc_core::sc_module_name& name) : sc_module(name) { SC_THREAD(program); }
  tlm_utils::simple_initiator_socket<Processor> bus{"bus"};
  sc_core::sc_vector<sc_core::sc_in<bool>> interrupt{"interrupt", kGpus};
  bool failed = false;

  struct Entry {
    std::uint32_t trace, error;
    std::uint64_t cycles;
  };
  static std::uint64_t address_of(std::size_t round, std::size_t gpu) {
    return kMemory + (round * kGpus + gpu) * sizeof(Entry);
  }

 private:
  void transfer(tlm::tlm_command command, std::uint64_t address, void* data, unsigned bytes) {
    tlm::tlm_generic_payload payload;
    payload.set_command(command);
    payload.set_address(address);
    payload.set_data_ptr(static_cast<unsigned char*>(data));
    payload.set_data_length(bytes);
    payload.set_streaming_width(bytes);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    bus->b_transport(payload, delay);
    wait(delay);
    if (payload.is_response_error()) failed = true;
  }
  static std::uint64_t gpu_register(std::size_t gpu, GpuRegister which) {
    return kGpu + gpu * kGpuStride + static_cast<std::uint64_t>(which);
  }
  template <typename Word>
  Word read(std::size_t gpu, GpuRegister from) {
    Word word = 0;
    transfer(tlm::TLM_READ_COMMAND, gpu_register(gpu, from), &word, sizeof word);
    return word;
  }
  void write(std::size_t gpu, GpuRegister to, std::uint32_t word) {
    transfer(tlm::TLM_WRITE_COMMAND, gpu_register(gpu, to), &word, sizeof word);
  }
  void program() {
    wait(sc_core::sc_time(1, sc_core::SC_US));  // the list is loaded
    for (std::size_t round = 0; round < kLaunches; ++round) {
      std::array<Entry, kGpus> list{};
      transfer(tlm::TLM_READ_COMMAND, address_of(round, 0), list.data(), sizeof list);
      for (std::size_t gpu = 0; gpu < kGpus; ++gpu) {
        write(gpu, GpuRegister::trace, list[gpu].trace);
        write(gpu, GpuRegister::control, ControlBits::kStart);
      }
      for (std::size_t gpu = 0; gpu < kGpus; ++gpu) {
        while (!interrupt[gpu].read()) wait(interrupt[gpu].posedge_event());
        list[gpu].cycles = read<std::uint64_t>(gpu, GpuRegister::cycles);
        list[gpu].error = read<std::uint32_t>(gpu, GpuRegister::error);
        write(gpu, GpuRegister::control, ControlBits::kAcknowledge);
        failed = failed || (read<std::uint32_t>(gpu, GpuRegister::status) & StatusBits::kError) != 0;
      }
      transfer(tlm::TLM_WRITE_COMMAND, address_of(round, 0), list.data(), sizeof list);
    }
  }
};

/// Debug access to the memory, as a loader has it.
void debug(Bus& bus, tlm::tlm_command command, std::uint64_t address, Processor::Entry& entry) {
  tlm::tlm_generic_payload payload;
  payload.set_command(command);
  payload.set_address(address);
  payload.set_data_ptr(reinterpret_cast<unsigned char*>(&entry));
  payload.set_data_length(sizeof entry);
  payload.set_streaming_width(sizeof entry);
  if (bus.memory->transport_dbg(payload) != sizeof entry) throw grtx::Error("platform", "memory", "is too small");
}

int run(int argc, char** argv) {
  if (argc != 4) throw grtx::Error("platform", "arguments", "MACHINE A.grtx B.grtx: a name (ada) or a file .toml");
  grtx::modules::set_time_resolution_to_fs();  // before anything else of SystemC
  GpuComponent::Options options;
  grtx::sim::set_machines_folder(grtx::kMachinesFolder);
  options.machine = grtx::sim::load_config(argv[1], {});
  options.traces = {argv[2], argv[3]};

  Processor processor("processor");
  Bus bus("bus");
  Memory memory("memory");
  GpuComponent gpu0("gpu0", options), gpu1("gpu1", options);
  std::array<sc_core::sc_signal<bool>, kGpus> lines;
  processor.bus.bind(bus.master);
  bus.memory.bind(memory.socket);
  const std::array<GpuComponent*, kGpus> gpus = {&gpu0, &gpu1};
  for (std::size_t i = 0; i < kGpus; ++i) {
    bus.gpu[i].bind(gpus[i]->registers);
    gpus[i]->interrupt.bind(lines[i]);
    processor.interrupt[i].bind(lines[i]);
  }

  // The first GPU runs A and then B, the second B and then A.
  sc_core::sc_start(sc_core::SC_ZERO_TIME);
  for (std::size_t round = 0; round < kLaunches; ++round) {
    for (std::size_t gpu = 0; gpu < kGpus; ++gpu) {
      Processor::Entry entry{static_cast<std::uint32_t>((round + gpu) % 2), 0, 0};
      debug(bus, tlm::TLM_WRITE_COMMAND, Processor::address_of(round, gpu), entry);
    }
  }
  sc_core::sc_start();  // until nobody has anything to do: no GPU stops the kernel
  for (std::size_t round = 0; round < kLaunches; ++round) {
    for (std::size_t gpu = 0; gpu < kGpus; ++gpu) {
      Processor::Entry entry{};
      debug(bus, tlm::TLM_READ_COMMAND, Processor::address_of(round, gpu), entry);
      std::printf("%s launch %zu: trace %u, %llu cycles, error %u\n", gpus[gpu]->name(), round, entry.trace,
                  static_cast<unsigned long long>(entry.cycles), entry.error);
    }
  }
  std::printf("the platform's time: %s\n", sc_core::sc_time_stamp().to_string().c_str());
  return processor.failed ? 1 : 0;
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
