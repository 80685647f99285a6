// SPDX-License-Identifier: Apache-2.0
// Both ends of a TLM-2.0 AT socket for tests: a scripted initiator and a target with all the awkward behaviours the
// standard allows, and some it does not.
#pragma once

#include <tlm_utils/simple_target_socket.h>
#include <deque>
#include <functional>
#include <map>
#include <tlm>
#include <utility>
#include <vector>

#include "grtx/modules/tlm/at_initiator.h"
#include "grtx/modules/tlm/at_payload_pool.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {

/// Sends requests in order, each in the given core cycle or as soon as the socket is free after it.
class AtDriver final : public sc_core::sc_module {
 public:
  AtDriver(const sc_core::sc_module_name& name, ClockDomain& clock)
      : sc_module(name),
        initiator("socket", clock),
        clock_(clock),
        process_("process", clock, [this](Cycle now) { tick(now); }) {}

  std::uint32_t at(Cycle cycle, std::uint64_t address, bool write = false, unsigned bytes = 32) {
    script_.push_back({cycle, address, bytes, write});
    clock_.request(cycle);
    return next_id_++;
  }
  struct Answer {
    Cycle cycle = 0;
    AtInitiator::Completion completion;
  };
  const std::vector<Answer>& answers() const { return answers_; }
  const std::vector<Cycle>& sent_at() const { return sent_at_; }
  Cycle answered(std::uint32_t id) const {
    for (const Answer& a : answers_) {
      if (a.completion.context == id) return a.cycle;
    }
    return kNever;
  }
  bool complete() const {
    std::vector<int> seen(next_id_, 0);
    for (const Answer& a : answers_) ++seen.at(a.completion.context);
    return initiator.idle() && initiator.pool().live() == 0 &&
           std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; });
  }

  AtInitiator initiator;

 private:
  struct Request {
    Cycle cycle;
    std::uint64_t address;
    unsigned bytes;
    bool write;
  };
  void tick(Cycle now) {
    initiator.update(now);
    while (const AtInitiator::Completion* c = initiator.front(now)) {
      answers_.push_back({now, *c});
      initiator.pop();
    }
    if (script_.empty()) return;
    if (script_.front().cycle > now) return clock_.request(script_.front().cycle);
    if (!initiator.can_send(now)) return;  // woken by the end of the request phase
    const Request r = script_.front();
    script_.pop_front();
    sent_at_.push_back(now);
    initiator.send(r.address, r.bytes, r.write, static_cast<std::uint32_t>(sent_at_.size() - 1));
    clock_.request(now + 1);
  }

  ClockDomain& clock_;
  std::deque<Request> script_;
  std::vector<Answer> answers_;
  std::vector<Cycle> sent_at_;
  std::uint32_t next_id_ = 0;
  TickProcess process_;
};

/// Behaviour of a MockAtTarget towards a request.
enum class AtBehaviour {
  plain,              ///< END_REQ and BEGIN_RESP as calls, END_RESP by either way
  withheld,           ///< END_REQ long after
  no_end_request,     ///< BEGIN_RESP stands for END_REQ
  updated,            ///< BEGIN_REQ returns TLM_UPDATED with END_REQ
  updated_response,   ///< BEGIN_REQ returns TLM_UPDATED with BEGIN_RESP
  completed,          ///< BEGIN_REQ returns TLM_COMPLETED
  annotated,          ///< non-zero delays on the backward path
  out_of_order,       ///< every second response overtakes its predecessor
  rewritten_address,  ///< as DRAMSys' arbiter does
  auto_extension,     ///< leaves an automatic extension in the payload
  // What the standard forbids:
  no_status,             ///< BEGIN_RESP with TLM_INCOMPLETE_RESPONSE
  two_responses,         ///< BEGIN_RESP twice for one transaction
  changed_length,        ///< modifies the data length
  late_end_request,      ///< END_REQ after BEGIN_RESP
  backward_delay,        ///< time plus delay goes back between END_REQ and BEGIN_RESP
  wrong_phase,           ///< returns TLM_UPDATED with END_RESP for BEGIN_REQ
  overlapping_responses  ///< BEGIN_RESP before END_RESP of the previous response
};

class MockAtTarget final : public sc_core::sc_module {
 public:
  MockAtTarget(const sc_core::sc_module_name& name, ClockDomain& clock, AtBehaviour behaviour)
      : sc_module(name),
        socket("socket"),
        clock_(clock),
        behaviour_(behaviour),
        process_("process", clock, [this](Cycle now) { tick(now); }) {
    socket.register_nb_transport_fw(this, &MockAtTarget::nb_transport_fw);
    socket.register_b_transport(this, &MockAtTarget::b_transport);
  }
  tlm_utils::simple_target_socket<MockAtTarget, 32> socket;
  std::uint64_t extensions_freed() const { return extensions_freed_; }

  static constexpr Cycle kLatency = 40;

 private:
  using Payload = ::tlm::tlm_generic_payload;

  struct Mark final : ::tlm::tlm_extension<Mark> {
    explicit Mark(std::uint64_t* freed) : freed_(freed) {}
    ::tlm::tlm_extension_base* clone() const override { return new Mark(freed_); }
    void copy_from(const ::tlm::tlm_extension_base&) override {}
    void free() override {
      ++*freed_;
      delete this;
    }
    std::uint64_t* freed_;
  };

  ::tlm::tlm_sync_enum nb_transport_fw(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    const Cycle edge = clock_.edge_after(delay.value());
    if (phase == tlm::END_RESP) {
      responding_ = false;
      release(payload);
      clock_.request(edge);
      return ::tlm::TLM_ACCEPTED;
    }
    if (phase != tlm::BEGIN_REQ) return tlm::TLM_ACCEPTED;
    if (payload.has_mm()) payload.acquire();
    ++count_;
    const Cycle response = edge + kLatency + (behaviour_ == AtBehaviour::out_of_order && count_ % 2 == 1 ? 100 : 0);
    switch (behaviour_) {
      case AtBehaviour::updated:
        phase = tlm::END_REQ;
        delay += period();
        later(response, [this, &payload] { respond(payload); });
        return ::tlm::TLM_UPDATED;
      case AtBehaviour::updated_response:
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
        phase = tlm::BEGIN_RESP;
        delay += period() * 7;
        return ::tlm::TLM_UPDATED;
      case AtBehaviour::completed:
        payload.set_response_status(::tlm::TLM_OK_RESPONSE);
        delay += period() * 9;
        payload.release();
        return ::tlm::TLM_COMPLETED;
      case AtBehaviour::wrong_phase:
        phase = tlm::END_RESP;
        return ::tlm::TLM_UPDATED;
      default:
        break;
    }
    if (behaviour_ != AtBehaviour::no_end_request && behaviour_ != AtBehaviour::late_end_request) {
      later(edge + (behaviour_ == AtBehaviour::withheld ? 500 : 0), [this, &payload] { end_request(payload); });
    }
    later(response + (behaviour_ == AtBehaviour::withheld ? 500 : 0), [this, &payload] { respond(payload); });
    return ::tlm::TLM_ACCEPTED;
  }

  void end_request(Payload& payload) {
    if (behaviour_ == AtBehaviour::rewritten_address) payload.set_address(payload.get_address() ^ 0xFF00);
    if (behaviour_ == AtBehaviour::auto_extension) payload.set_auto_extension(new Mark(&extensions_freed_));
    ::tlm::tlm_phase phase = tlm::END_REQ;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    if (behaviour_ == AtBehaviour::annotated) delay = period() * 3;
    if (behaviour_ == AtBehaviour::backward_delay) delay = period() * 1000;
    socket->nb_transport_bw(payload, phase, delay);
  }

  void respond(Payload& payload) {
    if (responding_ && behaviour_ != AtBehaviour::overlapping_responses) {  // one response phase at a time
      later(clock_.cycle() + 1, [this, &payload] { respond(payload); });
      return;
    }
    if (behaviour_ != AtBehaviour::no_status) payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    if (behaviour_ == AtBehaviour::changed_length) payload.set_data_length(16);
    begin_response(payload);
    if (behaviour_ == AtBehaviour::late_end_request) end_request(payload);
    if (behaviour_ == AtBehaviour::two_responses) begin_response(payload);
  }

  void begin_response(Payload& payload) {
    ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
    sc_core::sc_time delay = behaviour_ == AtBehaviour::annotated ? period() * 5 : sc_core::SC_ZERO_TIME;
    responding_ = true;
    const ::tlm::tlm_sync_enum status = socket->nb_transport_bw(payload, phase, delay);
    if (status == ::tlm::TLM_ACCEPTED) return;
    if (behaviour_ != AtBehaviour::two_responses) release(payload);
    const Cycle end = clock_.edge_after(delay.value());
    later(end, [this] { responding_ = false; });
  }

  static void release(Payload& payload) {
    if (payload.has_mm()) payload.release();
  }
  void b_transport(Payload& payload, sc_core::sc_time&) { payload.set_response_status(::tlm::TLM_OK_RESPONSE); }

  sc_core::sc_time period() const { return sc_core::sc_time::from_value(clock_.period_fs()); }
  void later(Cycle cycle, std::function<void()> action) {
    actions_.emplace(cycle, std::move(action));
    clock_.request(cycle);
  }
  void tick(Cycle now) {
    while (!actions_.empty() && actions_.begin()->first <= now) {
      const std::function<void()> action = std::move(actions_.begin()->second);
      actions_.erase(actions_.begin());
      action();
    }
    if (!actions_.empty()) clock_.request(actions_.begin()->first);
  }

  ClockDomain& clock_;
  AtBehaviour behaviour_;
  std::multimap<Cycle, std::function<void()>> actions_;
  bool responding_ = false;
  std::uint64_t count_ = 0;
  std::uint64_t extensions_freed_ = 0;
  TickProcess process_;
};

/// An initiator that passes wrong attributes or phases on purpose and takes responses as it should.
class RawAtInitiator final : public sc_core::sc_module {
 public:
  explicit RawAtInitiator(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_nb_transport_bw(this, &RawAtInitiator::nb_transport_bw);
  }
  tlm_utils::simple_initiator_socket<RawAtInitiator, 32> socket;
  AtPayloadPool pool;
  ::tlm::tlm_sync_enum answer = ::tlm::TLM_UPDATED;  ///< to BEGIN_RESP
  sc_core::sc_time end_response_after{1, sc_core::SC_NS};

  /// A correct 32 B read.
  AtPayload& payload(std::uint64_t address = 0) {
    AtPayload& p = pool.acquire();
    p.set_read();
    p.set_address(address);
    p.set_data_ptr(p.data.data());
    p.set_data_length(32);
    p.set_streaming_width(32);
    p.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
    return p;
  }
  void send(::tlm::tlm_generic_payload& p, ::tlm::tlm_phase phase = tlm::BEGIN_REQ,
            sc_core::sc_time delay = sc_core::SC_ZERO_TIME) {
    socket->nb_transport_fw(p, phase, delay);
  }

 private:
  ::tlm::tlm_sync_enum nb_transport_bw(::tlm::tlm_generic_payload&, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    if (phase != tlm::BEGIN_RESP) return ::tlm::TLM_ACCEPTED;
    if (answer == ::tlm::TLM_UPDATED) {
      phase = tlm::END_RESP;
      delay += end_response_after;
    }
    return answer;
  }
};

}  // namespace grtx::modules
