// SPDX-License-Identifier: Apache-2.0
// A foreign TLM-2.0 initiator drives L1 -> L2 -> DRAM of the library, with blocking calls at times that are no clock
// edge of it; nothing else is under way, so the time of each access is a formula.
#include <tlm_utils/simple_initiator_socket.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/cache/l2_slice_if.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/tlm/tlm_to_link.h"

namespace {

using grtx::Cycle;

/// Knows nothing of the library but its socket.
class Processor final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = Processor;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  explicit Processor(const sc_core::sc_module_name& name) : sc_module(name) { SC_THREAD(run); }

  tlm_utils::simple_initiator_socket<Processor, 32> socket{"socket"};
  struct Access {
    std::uint64_t address;
    std::uint64_t begin_fs;
    std::uint64_t end_fs;
  };
  std::vector<Access> accesses{{0x5000, 100'123'457, 0}, {0x5000, 2'000'000'001, 0}, {0x5020, 3'000'777'777, 0}};

 private:
  void run() {
    for (Access& access : accesses) {
      wait(sc_core::sc_time::from_value(access.begin_fs) - sc_core::sc_time_stamp());
      std::array<unsigned char, 32> data{};
      tlm::tlm_generic_payload payload;
      payload.set_command(tlm::TLM_READ_COMMAND);
      payload.set_address(access.address);
      payload.set_data_ptr(data.data());
      payload.set_data_length(data.size());
      payload.set_streaming_width(data.size());
      payload.set_byte_enable_ptr(nullptr);
      payload.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      socket->b_transport(payload, delay);
      wait(delay);
      if (payload.is_response_ok()) access.end_fs = sc_core::sc_time_stamp().value();
    }
  }
};

int drive() {
  using namespace grtx::modules;
  set_time_resolution_to_fs();
  ClockDomain core("core", 1365.0);
  ClockDomain memory("memory", 3500.0);
  const AddressInterleave one_slice{1};
  L1CacheConfig l1_config;
  l1_config.clients = 1;
  L2SliceConfig l2_config;
  l2_config.interleave = one_slice;
  Dram::Config dram_config;
  dram_config.interleave = one_slice;

  Processor processor("processor");
  TlmToLink bridge("bridge", TlmToLink::Config(), core);
  const std::unique_ptr<L1CacheModule> l1 = make_l1_cache("l1", l1_config, core);
  const std::unique_ptr<L2SliceModule> l2 = make_l2_slice("l2", l2_config, core);
  Dram dram("dram", dram_config, memory);
  Link<MemoryRequest> to_l1("to_l1", 1, 4), to_l2("to_l2", 1, 4);
  Link<MemoryResponse> from_l1("from_l1", 1, 4), from_l2("from_l2", 1, 4);
  processor.socket.bind(bridge.socket);
  bridge.request(to_l1);
  bridge.response(from_l1);
  l1->request[0](to_l1);
  l1->response[0](from_l1);
  l1->to_memory(to_l2);
  l1->from_memory(from_l2);
  l2->request(to_l2);
  l2->response(from_l2);
  l2->memory_socket().bind(dram.sockets[0]);
  sc_core::sc_start();

  // Seen at the first edge after the call, at the L1 one link later. A miss goes through its tags and a link to the L2,
  // through that to the DRAM, which sees it at its own next edge; the L2 sees the data at its next edge, and two links
  // lead back.
  const std::uint64_t core_fs = core.period_fs(), memory_fs = memory.period_fs();
  const DramTiming& timing = dram_config.channel.timing;
  const auto at_l1 = [&](std::uint64_t begin) { return begin / core_fs + 1 + to_l1.latency(); };
  const auto from_dram = [&](std::uint64_t begin, Cycle clocks) {
    const Cycle sent = at_l1(begin) + l1_config.tag_latency + to_l2.latency() + l2_config.latency;
    const Cycle filled =
        (sent * core_fs / memory_fs + 1 + clocks + dram_config.fixed_latency) * memory_fs / core_fs + 1;
    return (filled + from_l2.latency() + from_l1.latency()) * core_fs;
  };
  const auto from_l1_hit = [&](std::uint64_t begin) { return (at_l1(begin) + l1_config.latency) * core_fs; };
  const std::vector<Processor::Access>& done = processor.accesses;
  const std::uint64_t expected[] = {from_dram(done[0].begin_fs, timing.rcd + timing.cl + timing.ccd),  // closed row
                                    from_l1_hit(done[1].begin_fs),
                                    from_dram(done[2].begin_fs, timing.cl + timing.ccd)};  // open row
  const char* const names[] = {"DRAM, closed row", "L1 hit", "DRAM, open row"};
  bool same = l1->idle() && l2->idle() && dram.idle();
  for (std::size_t i = 0; i < done.size(); ++i) {
    std::printf("%-16s %8.3f ns, by the formula %8.3f ns\n", names[i],
                static_cast<double>(done[i].end_fs - done[i].begin_fs) * 1e-6,
                static_cast<double>(expected[i] - done[i].begin_fs) * 1e-6);
    same = same && done[i].end_fs == expected[i];
  }
  return same ? 0 : 1;
}

}  // namespace

int sc_main(int, char**) {
  try {
    return drive();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "foreign_initiator: %s\n", error.what());
    return 2;
  }
}
