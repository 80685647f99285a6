// SPDX-License-Identifier: Apache-2.0
// A memory that does whatever the TLM-2.0 base protocol allows, at random: latency, order, withheld END_REQ, annotated
// delays, completion on the spot. Its refresh never ends, so the kernel always has something to do.
#pragma once

#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

#include <deque>
#include <memory>
#include <random>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/monitored_memory.h"

namespace grtx::sim::test {

struct HostileBehaviour {
  std::uint64_t seed = 1;
  unsigned least_ns = 20;
  unsigned most_ns = 400;
  std::uint64_t silent_after = ~std::uint64_t{0};  ///< requests that are answered; the rest is taken and forgotten
  std::uint64_t bytes = ~std::uint64_t{0};         ///< addresses beyond get an error response
};

class HostileTarget final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = HostileTarget;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  HostileTarget(const sc_core::sc_module_name& name, const HostileBehaviour& behaviour)
      : sc_module(name), behaviour_(behaviour), random_(behaviour.seed) {
    socket.register_nb_transport_fw(this, &HostileTarget::nb_transport_fw);
    SC_METHOD(end_requests);
    sensitive << end_requests_.get_event();
    dont_initialize();
    SC_METHOD(take_due);
    sensitive << due_.get_event();
    dont_initialize();
    SC_METHOD(respond);
    sensitive << next_response_;
    dont_initialize();
    SC_METHOD(refresh);
  }
  tlm_utils::simple_target_socket<HostileTarget, 32> socket{"socket"};
  std::uint64_t requests = 0;
  std::uint64_t refreshes = 0;

 private:
  using Payload = ::tlm::tlm_generic_payload;

  sc_core::sc_time up_to(unsigned ns) { return {static_cast<double>(random_() % (ns * 64)) / 64.0, sc_core::SC_NS}; }
  bool chance(unsigned percent) { return random_() % 100 < percent; }

  ::tlm::tlm_sync_enum nb_transport_fw(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    if (phase == ::tlm::END_RESP) {
      responding_ = false;
      payload.release();
      next_response_.notify(delay);
      return ::tlm::TLM_ACCEPTED;
    }
    if (phase != ::tlm::BEGIN_REQ) return ::tlm::TLM_ACCEPTED;
    ++requests;
    const bool inside = payload.get_address() + payload.get_data_length() <= behaviour_.bytes;
    payload.set_response_status(inside ? ::tlm::TLM_OK_RESPONSE : ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
    if (requests <= behaviour_.silent_after && chance(10)) {
      delay += up_to(behaviour_.least_ns);
      return ::tlm::TLM_COMPLETED;
    }
    payload.acquire();
    if (chance(50)) {
      phase = ::tlm::END_REQ;
      delay += up_to(5);
      answer_later(payload, delay);
      return ::tlm::TLM_UPDATED;
    }
    // The response may come first and then stands for END_REQ.
    end_requests_.notify(payload, delay + up_to(behaviour_.most_ns / 4));
    requested_.push_back(&payload);
    answer_later(payload, delay);
    return ::tlm::TLM_ACCEPTED;
  }
  void answer_later(Payload& payload, const sc_core::sc_time& delay) {
    if (requests > behaviour_.silent_after) return;
    const sc_core::sc_time least(behaviour_.least_ns, sc_core::SC_NS);
    due_.notify(payload, delay + least + up_to(behaviour_.most_ns - behaviour_.least_ns));
  }
  bool end_request(Payload& payload) {
    const auto at = std::find(requested_.begin(), requested_.end(), &payload);
    if (at == requested_.end()) return false;
    requested_.erase(at);
    return true;
  }
  void end_requests() {
    while (Payload* payload = end_requests_.get_next_transaction()) {
      if (!end_request(*payload)) continue;
      ::tlm::tlm_phase phase = ::tlm::END_REQ;
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      socket->nb_transport_bw(*payload, phase, delay);
    }
  }
  void take_due() {
    while (Payload* payload = due_.get_next_transaction()) responses_.push_back(payload);
    next_response_.notify(sc_core::SC_ZERO_TIME);
  }
  void respond() {
    if (responding_ || responses_.empty()) return;
    Payload& payload = *responses_.front();
    responses_.pop_front();
    responding_ = true;
    end_request(payload);
    ::tlm::tlm_phase phase = ::tlm::BEGIN_RESP;
    sc_core::sc_time delay = chance(30) ? up_to(10) : sc_core::SC_ZERO_TIME;
    const ::tlm::tlm_sync_enum status = socket->nb_transport_bw(payload, phase, delay);
    if (status == ::tlm::TLM_ACCEPTED) return;
    responding_ = false;
    payload.release();
    next_response_.notify(delay);
  }
  void refresh() {
    ++refreshes;
    next_trigger(1, sc_core::SC_US);
  }

  HostileBehaviour behaviour_;
  std::mt19937_64 random_;
  tlm_utils::peq_with_get<Payload> end_requests_{"held"};
  tlm_utils::peq_with_get<Payload> due_{"due"};
  sc_core::sc_event next_response_;
  std::vector<Payload*> requested_;
  std::deque<Payload*> responses_;
  bool responding_ = false;
};

class HostileMemory final : public MonitoredMemory {
 public:
  HostileMemory(Gpu& gpu, const HostileBehaviour& behaviour) : MonitoredMemory(gpu, "hostile", true) {
    for (unsigned i = 0; i < channels(); ++i) {
      targets_.push_back(std::make_unique<HostileTarget>(("hostile" + std::to_string(i)).c_str(), behaviour));
      socket(i).bind(targets_.back()->socket);
    }
  }
  void statistics(modules::StatisticList& list, const std::string& prefix) const override {
    MonitoredMemory::statistics(list, prefix);
    list.add(prefix + ".refreshes", targets_.front()->refreshes, "commands", "refreshes of channel 0",
             modules::StatisticKind::count);
  }
  std::vector<MemoryProbe> probes() const override {
    return {{"refreshes", 32, [this] { return targets_.front()->refreshes; }}};
  }

 private:
  std::vector<std::unique_ptr<HostileTarget>> targets_;
};

}  // namespace grtx::sim::test
