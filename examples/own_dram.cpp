// A program that runs a trace on the GPU model with a DRAM of its own instead of the built-in one:
//   own_dram TRACE.grtx [LATENCY_NS [BYTES_PER_NS]]
// Anything with a TLM-2.0 base-protocol target socket of 32 bits can take the place of SimpleDram below: one socket an
// L2 slice, requests of 32 B, approximately timed. DRAM simulators bring such a target or a wrapper for it.
#include <fmt/format.h>
#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "grtx/traces/reader.h"

namespace {

/// One channel: a fixed latency, and a data bus of limited bandwidth. No banks, no rows, no queue limit.
class SimpleDram final : public sc_core::sc_module {
 public:
  SC_HAS_PROCESS(SimpleDram);
  SimpleDram(const sc_core::sc_module_name& name, double latency_ns, double bytes_per_ns)
      : sc_module(name), latency_(latency_ns, sc_core::SC_NS), bytes_per_ns_(bytes_per_ns) {
    socket.register_nb_transport_fw(this, &SimpleDram::nb_transport_fw);
    SC_METHOD(respond);
    sensitive << due_.get_event();
    dont_initialize();
  }

  tlm_utils::simple_target_socket<SimpleDram, 32> socket{"socket"};
  std::uint64_t reads = 0;
  std::uint64_t writes = 0;

 private:
  tlm::tlm_sync_enum nb_transport_fw(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                     sc_core::sc_time& delay) {
    if (phase != tlm::BEGIN_REQ) return tlm::TLM_ACCEPTED;  // END_RESP comes as the return value of our own call
    payload.acquire();                                      // until the response has ended
    ++(payload.is_write() ? writes : reads);
    const sc_core::sc_time now = sc_core::sc_time_stamp() + delay;
    const sc_core::sc_time burst(payload.get_data_length() / bytes_per_ns_, sc_core::SC_NS);
    bus_free_ = std::max(bus_free_, now + latency_) + burst;
    due_.notify(payload, bus_free_ - sc_core::sc_time_stamp());
    phase = tlm::END_REQ;  // the request is taken at once
    return tlm::TLM_UPDATED;
  }

  void respond() {
    while (tlm::tlm_generic_payload* payload = due_.get_next_transaction()) {
      payload->set_response_status(tlm::TLM_OK_RESPONSE);
      tlm::tlm_phase phase = tlm::BEGIN_RESP;
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      const tlm::tlm_sync_enum status = socket->nb_transport_bw(*payload, phase, delay);
      // The GPU ends a response in its own next cycle; the bus above is slower than that, so responses never meet.
      sc_assert(status == tlm::TLM_COMPLETED || phase == tlm::END_RESP);
      payload->release();
    }
  }

  sc_core::sc_time latency_;
  double bytes_per_ns_;
  sc_core::sc_time bus_free_;
  tlm_utils::peq_with_get<tlm::tlm_generic_payload> due_{"due"};
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
  if (argc < 2) throw grtx::Error("own_dram", "arguments", "TRACE.grtx [LATENCY_NS [BYTES_PER_NS]]");
  const double latency = argc > 2 ? number(argv[2]) : 80.0;
  const double bandwidth = argc > 3 ? number(argv[3]) : 28.0;

  // The model as `grtx sim` builds it, with the same configuration keys.
  const grtx::sim::GpuConfig config = grtx::sim::load_config("", {"gpu.sms=2", "l2.slices=2"});
  if (32.0 / bandwidth < 1000.0 / config.core_mhz) {
    throw grtx::Error("own_dram", argv[3], "responses must not come faster than one a core cycle");
  }
  const grtx::traces::Reader reader(argv[1]);
  grtx::sim::TraceSource source(reader);
  grtx::modules::set_time_resolution_to_fs();
  grtx::sim::Gpu gpu("gpu", config, reader.header(), reader.totals().max_evictions_per_ray, source, {});

  // The only part that is ours.
  std::vector<std::unique_ptr<SimpleDram>> dram;
  for (unsigned i = 0; i < gpu.dram.size(); ++i) {
    dram.push_back(std::make_unique<SimpleDram>(fmt::format("my_dram{}", i).c_str(), latency, bandwidth));
    gpu.dram[i].bind(dram.back()->socket);
  }

  sc_core::sc_start();  // returns when the last warp has ended: the GPU pauses the kernel
  std::uint64_t reads = 0, writes = 0;
  for (const auto& channel : dram) {
    reads += channel->reads;
    writes += channel->writes;
  }
  fmt::print("{} cycles, {} DRAM reads, {} DRAM writes\n", gpu.distributor().end_cycle(), reads, writes);
  return 0;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
