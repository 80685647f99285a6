// SPDX-License-Identifier: Apache-2.0
// Runs a trace on the GPU model with a memory of this program's own: approximately timed, of random latency, and so
// small that it holds back requests all the time. The simulator's watchdog, conservation laws, statistics and waveforms
// see it.
//   own_memory TRACE.grtx WAVES.vcd         the run
//   own_memory TRACE.grtx WAVES.vcd stuck   the memory stops answering: the watchdog must say so
#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

#include <cstdint>
#include <cstdio>
#include <deque>
#include <exception>
#include <fstream>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <systemc>
#include <tlm>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

/// One channel: answers after 30 to 300 ns, in the order in which that is over, and holds three requests at most. A
/// fourth waits in its request phase.
class RandomMemory final : public sc_core::sc_module {
 public:
  static constexpr std::size_t kRoom = 3;

  using SC_CURRENT_USER_MODULE = RandomMemory;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  RandomMemory(const sc_core::sc_module_name& name, unsigned seed, std::uint64_t stops_after)
      : sc_module(name), random_(seed), stops_after_(stops_after) {
    socket.register_nb_transport_fw(this, &RandomMemory::nb_transport_fw);
    SC_METHOD(respond);
    sensitive << due_.get_event() << response_ended_;
    dont_initialize();
  }

  tlm_utils::simple_target_socket<RandomMemory, 32> socket{"socket"};
  std::uint64_t requests = 0;
  std::uint64_t held_back = 0;
  std::uint64_t bytes = 0;

 private:
  tlm::tlm_sync_enum nb_transport_fw(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                     sc_core::sc_time& delay) {
    if (phase == tlm::END_RESP) {
      payload.release();
      response_ended_.notify(delay);
      return tlm::TLM_COMPLETED;
    }
    payload.acquire();
    ++requests;
    bytes += payload.get_data_length();
    if (inside_ == kRoom) {
      ++held_back;
      waiting_ = &payload;
      return tlm::TLM_ACCEPTED;
    }
    take(payload, delay);
    phase = tlm::END_REQ;
    return tlm::TLM_UPDATED;
  }

  void take(tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay) {
    ++inside_;
    const double latency = std::uniform_real_distribution<>(30.0, 300.0)(random_);
    if (requests <= stops_after_) due_.notify(payload, delay + sc_core::sc_time(latency, sc_core::SC_NS));
  }

  void respond() {
    while (tlm::tlm_generic_payload* payload = due_.get_next_transaction()) done_.push_back(payload);
    if (answering_ && !response_ended_.triggered()) return;
    answering_ = false;
    if (done_.empty()) return;
    tlm::tlm_generic_payload& payload = *done_.front();
    done_.pop_front();
    --inside_;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    if (tlm::tlm_generic_payload* next = std::exchange(waiting_, nullptr); next != nullptr) {
      take(*next, delay);
      tlm::tlm_phase phase = tlm::END_REQ;
      socket->nb_transport_bw(*next, phase, delay);
    }
    answering_ = true;
    payload.set_response_status(tlm::TLM_OK_RESPONSE);
    tlm::tlm_phase phase = tlm::BEGIN_RESP;
    delay = sc_core::SC_ZERO_TIME;
    socket->nb_transport_bw(payload, phase, delay);  // accepted; END_RESP comes as a call
  }

  std::mt19937 random_;
  std::uint64_t stops_after_;
  std::size_t inside_ = 0;
  bool answering_ = false;
  tlm::tlm_generic_payload* waiting_ = nullptr;
  std::deque<tlm::tlm_generic_payload*> done_;
  tlm_utils::peq_with_get<tlm::tlm_generic_payload> due_{"due"};
  sc_core::sc_event response_ended_;
};

class OwnMemory final : public grtx::sim::MonitoredMemory {
 public:
  /// What is left of it when the run has ended and taken the memory with it.
  struct Seen {
    std::uint64_t requests = 0;
    std::uint64_t held_back = 0;
    std::uint64_t bytes = 0;
  };

  OwnMemory(grtx::sim::Gpu& gpu, Seen& seen, std::uint64_t stops_after)
      : MonitoredMemory(gpu, "random", true), seen_(seen) {
    for (unsigned i = 0; i < channels(); ++i) {
      memories_.push_back(
          std::make_unique<RandomMemory>(("random_memory" + std::to_string(i)).c_str(), i + 1, stops_after));
      socket(i).bind(memories_.back()->socket);
    }
  }
  ~OwnMemory() override {
    for (const auto& memory : memories_) {
      seen_.requests += memory->requests;
      seen_.held_back += memory->held_back;
      seen_.bytes += memory->bytes;
    }
  }
  OwnMemory(const OwnMemory&) = delete;
  OwnMemory& operator=(const OwnMemory&) = delete;

 private:
  Seen& seen_;
  std::vector<std::unique_ptr<RandomMemory>> memories_;
};

int fail(const std::string& what) {
  std::fprintf(stderr, "own_memory: %s\n", what.c_str());
  return 1;
}

int run(const std::string& trace, const std::string& waves, bool stuck) {
  OwnMemory::Seen seen;
  grtx::sim::SimulationOptions options;
  options.waveform.path = waves;
  options.waveform.level = grtx::sim::WaveLevel::units;
  options.watchdog_cycles = 50'000;
  options.memory = [&](grtx::sim::Gpu& gpu, const grtx::sim::BuildOptions&) {
    return std::make_unique<OwnMemory>(gpu, seen, stuck ? 100 : ~std::uint64_t{0});
  };
  grtx::sim::set_machines_folder(
      grtx::kMachinesFolder);  // of the installation: a machine by name needs grtx::sim alone
  const grtx::sim::GpuConfig config = grtx::sim::load_config("paper", {"gpu.sms=2", "l2.slices=2"});
  grtx::sim::SimulationResult result;
  try {
    result = grtx::sim::simulate(trace, config, options);
  } catch (const std::runtime_error& stands_still) {
    if (!stuck) throw;
    std::printf("the watchdog: %s\n", stands_still.what());
    return 0;
  }
  if (stuck) return fail("the memory stopped answering, and the run ended all the same");

  for (const std::string& violation : result.violations) std::fprintf(stderr, "%s\n", violation.c_str());
  if (!result.violations.empty()) return fail("conservation laws do not hold");
  const auto& statistics = result.document.at("stats");
  const auto value = [&statistics](const char* name) { return statistics.at(name).at("value").get<double>(); };
  std::printf("%llu cycles, %llu requests, %llu of them held back, mean latency %.1f ns\n",
              static_cast<unsigned long long>(result.cycles), static_cast<unsigned long long>(seen.requests),
              static_cast<unsigned long long>(seen.held_back), value("gpu.dram.latency"));
  if (seen.held_back == 0) return fail("the memory never held back a request");
  if (value("gpu.dram.reads") + value("gpu.dram.writes") != static_cast<double>(seen.requests) ||
      value("gpu.dram.bytes") != static_cast<double>(seen.bytes)) {
    return fail("the statistics count other requests than the memory");
  }
  if (value("gpu.dram.latency") < 30.0) return fail("the mean latency is below the shortest one");

  std::ifstream file(waves);
  const std::string vcd{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (vcd.find("$enddefinitions") == std::string::npos || vcd.find("outstanding") == std::string::npos) {
    return fail("the waveform does not show the memory");
  }
  return 0;
}

}  // namespace

int sc_main(int argc, char** argv) {
  const bool stuck = argc == 4 && std::string(argv[3]) == "stuck";
  if (argc != 3 && !stuck) {
    std::fprintf(stderr, "own_memory TRACE.grtx WAVES.vcd [stuck]\n");
    return 2;
  }
  try {
    return run(argv[1], argv[2], stuck);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "own_memory: %s\n", error.what());
    return 2;
  }
}
