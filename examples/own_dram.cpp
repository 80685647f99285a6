// SPDX-License-Identifier: Apache-2.0
// A program that simulates a trace with a memory of its own in place of the built-in DRAM:
//   own_dram TRACE.grtx [LATENCY_NS [BYTES_PER_NS [WAVES.vcd]]]
// Anything with TLM-2.0 base-protocol target sockets of 32 bits can take the place of SimpleDram below (requests of
// 32 B, approximately timed; docs/model/tlm.md). The watchdog, the conservation laws, the statistics and the waveform
// are those of the built-in model.
#include <fmt/format.h>
#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

#include <algorithm>
#include <charconv>
#include <deque>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

/// One channel: a fixed latency, a data bus of limited bandwidth, and room for some requests: while they are taken,
/// END_REQ is withheld. No banks, no rows.
class SimpleDram final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = SimpleDram;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  SimpleDram(const sc_core::sc_module_name& name, double latency_ns, double bytes_per_ns)
      : sc_module(name), latency_(latency_ns, sc_core::SC_NS), bytes_per_ns_(bytes_per_ns) {
    socket.register_nb_transport_fw(this, &SimpleDram::nb_transport_fw);
    SC_METHOD(respond);
    sensitive << due_.get_event() << response_ended_;
    dont_initialize();
  }

  tlm_utils::simple_target_socket<SimpleDram, 32> socket{"socket"};
  double busy_ns() const { return busy_ns_; }  ///< of the data bus, with what was answered
  std::size_t inside() const { return inside_; }
  void restart() { busy_ns_ = 0.0; }

 private:
  static constexpr std::size_t kRoom = 16;

  tlm::tlm_sync_enum nb_transport_fw(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                     sc_core::sc_time& delay) {
    if (phase == tlm::END_RESP) {
      responding_ = false;
      response_ended_.notify(delay);
      payload.release();
    } else if (phase == tlm::BEGIN_REQ) {
      payload.acquire();  // until the response has ended
      const sc_core::sc_time now = sc_core::sc_time_stamp() + delay;
      const sc_core::sc_time burst(payload.get_data_length() / bytes_per_ns_, sc_core::SC_NS);
      bus_free_ = std::max(bus_free_, now + latency_) + burst;
      due_.notify(payload, bus_free_ - sc_core::sc_time_stamp());
      if (++inside_ < kRoom) {
        phase = tlm::END_REQ;
        return tlm::TLM_UPDATED;
      }
      waiting_ = &payload;
    }
    return tlm::TLM_ACCEPTED;
  }

  void respond() {
    while (tlm::tlm_generic_payload* payload = due_.get_next_transaction()) done_.push_back(payload);
    if (responding_ || done_.empty()) return;
    tlm::tlm_generic_payload& payload = *done_.front();
    done_.pop_front();
    --inside_;
    busy_ns_ += payload.get_data_length() / bytes_per_ns_;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    if (tlm::tlm_generic_payload* taken = std::exchange(waiting_, nullptr); taken != nullptr) {
      tlm::tlm_phase phase = tlm::END_REQ;
      socket->nb_transport_bw(*taken, phase, delay);
    }
    payload.set_response_status(tlm::TLM_OK_RESPONSE);
    responding_ = true;
    tlm::tlm_phase phase = tlm::BEGIN_RESP;
    delay = sc_core::SC_ZERO_TIME;
    socket->nb_transport_bw(payload, phase, delay);  // the GPU accepts; its END_RESP is a call, one core clock later
  }

  sc_core::sc_time latency_;
  double bytes_per_ns_;
  double busy_ns_ = 0.0;
  sc_core::sc_time bus_free_;
  std::size_t inside_ = 0;
  bool responding_ = false;
  tlm::tlm_generic_payload* waiting_ = nullptr;  ///< in its request phase: there was no room
  tlm_utils::peq_with_get<tlm::tlm_generic_payload> due_{"due"};
  std::deque<tlm::tlm_generic_payload*> done_;
  sc_core::sc_event response_ended_;
};

/// What the simulator asks of a memory: MonitoredMemory counts at the sockets, this adds what only SimpleDram knows.
class SimpleMemory final : public grtx::sim::MonitoredMemory {
 public:
  SimpleMemory(grtx::sim::Gpu& gpu, double latency_ns, double bytes_per_ns)
      : MonitoredMemory(gpu, "simple", true), core_mhz_(gpu.config().core_mhz) {
    for (unsigned i = 0; i < channels(); ++i) {
      dram_.push_back(std::make_unique<SimpleDram>(fmt::format("my_dram{}", i).c_str(), latency_ns, bytes_per_ns));
      socket(i).bind(dram_.back()->socket);
    }
  }
  double busy_core_cycles() const override {
    double busiest = 0.0;
    for (const auto& channel : dram_) busiest = std::max(busiest, channel->busy_ns());
    return busiest * core_mhz_ * 1e-3;
  }
  /// Before another launch (GpuComponent, SimulationOptions::warm_trace): what is counted here begins anew.
  bool restart(grtx::modules::Caches caches) override {
    for (const auto& channel : dram_) channel->restart();
    return MonitoredMemory::restart(caches);
  }
  std::vector<grtx::sim::MemoryProbe> probes() const override {
    std::vector<grtx::sim::MemoryProbe> all;
    for (std::size_t i = 0; i < dram_.size(); ++i) {
      all.push_back({fmt::format("channel{}.inside", i), 8, [this, i] { return dram_[i]->inside(); }});
    }
    return all;
  }

 private:
  double core_mhz_;
  std::vector<std::unique_ptr<SimpleDram>> dram_;
};

double number(const char* text) {
  double value = 0.0;
  const std::string word(text);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value <= 0.0) {
    throw grtx::Error("own_dram", word, "must be a number above 0");
  }
  return value;
}

int run(int argc, char** argv) {
  if (argc < 2) throw grtx::Error("own_dram", "arguments", "TRACE.grtx [LATENCY_NS [BYTES_PER_NS [WAVES.vcd]]]");
  const double latency = argc > 2 ? number(argv[2]) : 80.0;
  const double bandwidth = argc > 3 ? number(argv[3]) : 28.0;
  grtx::sim::SimulationOptions options;
  if (argc > 4) options.waveform.path = argv[4];
  // The only line that differs from a run with the built-in DRAM.
  options.memory = [=](grtx::sim::Gpu& gpu, const grtx::sim::BuildOptions&) {
    return std::make_unique<SimpleMemory>(gpu, latency, bandwidth);
  };
  const grtx::sim::GpuConfig config = grtx::sim::load_config("", {"gpu.sms=2", "l2.slices=2"});
  const grtx::sim::SimulationResult result = grtx::sim::simulate(argv[1], config, options);

  const auto& stats = result.document.at("stats");
  const auto value = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
  fmt::print("{} cycles, {:.0f} DRAM reads, {:.0f} DRAM writes\n", result.cycles, value("gpu.dram.reads"),
             value("gpu.dram.writes"));
  fmt::print("latency at the sockets {:.1f} ns, bound {:.0f} of {} cycles\n", value("gpu.dram.latency"),
             value("gpu.bound.dram_bandwidth"), result.cycles);
  for (const std::string& violation : result.violations) fmt::print("{}\n", violation);
  return result.violations.empty() ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  } catch (const std::exception& error) {  // the model stood still: its state is on stderr already
    fmt::print(stderr, "{}\n", error.what());
    return 3;
  }
}
