// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/tlm/at_protocol_checker.h"

#include <bit>

#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

using sc_core::sc_time;
using ::tlm::tlm_generic_payload;
using ::tlm::tlm_phase;
using ::tlm::tlm_sync_enum;

AtProtocolChecker::AtProtocolChecker(const sc_core::sc_module_name& name, const Config& config)
    : sc_module(name), target("target"), initiator("initiator"), config_(config) {
  target.register_nb_transport_fw(this, &AtProtocolChecker::forward);
  target.register_b_transport(this, &AtProtocolChecker::blocking);
  target.register_transport_dbg(this, &AtProtocolChecker::debug);
  target.register_get_direct_mem_ptr(this, &AtProtocolChecker::direct);
  initiator.register_nb_transport_bw(this, &AtProtocolChecker::backward);
  initiator.register_invalidate_direct_mem_ptr(this, &AtProtocolChecker::invalidate);
}

void AtProtocolChecker::require(bool holds, const char* clause, const std::string& what) {
  if (holds) return;
  ++violations_;
  if (messages_.size() >= config_.max_messages) return;
  messages_.push_back(std::string(name()) + " @" + sc_core::sc_time_stamp().to_string() + ": " + clause + ": " + what);
}

tlm_sync_enum AtProtocolChecker::forward(tlm_generic_payload& payload, tlm_phase& phase, sc_time& delay) {
  const bool begin = phase == tlm::BEGIN_REQ;
  const bool end = phase == tlm::END_RESP;
  require(begin || end || phase > tlm::END_RESP, "15.2.3 c", "only BEGIN_REQ and END_RESP travel forward");
  if (begin) begin_request(payload, delay);
  if (end) end_response(payload, delay);
  if (end) finish(payload);
  // When the call returns, an ended transaction may be back in its pool: do not read it after that.
  const tlm_sync_enum status = initiator->nb_transport_fw(payload, phase, delay);
  if (!begin) return status;

  if (status == ::tlm::TLM_UPDATED) {
    if (follow(payload, delay, "return of BEGIN_REQ") == nullptr) return status;
    require(phase == tlm::END_REQ || phase == tlm::BEGIN_RESP, "15.2.3 c", "BEGIN_REQ returned a wrong phase");
    if (phase == tlm::END_REQ) end_request(payload);
    if (phase == tlm::BEGIN_RESP) begin_response(payload, delay);
  } else if (status == ::tlm::TLM_COMPLETED) {
    require(payload.get_response_status() != ::tlm::TLM_INCOMPLETE_RESPONSE, "14.17", "completed without a status");
    finish(payload);
  }
  return status;
}

tlm_sync_enum AtProtocolChecker::backward(tlm_generic_payload& payload, tlm_phase& phase, sc_time& delay) {
  const bool response = phase == tlm::BEGIN_RESP;
  require(response || phase == tlm::END_REQ || phase > tlm::END_RESP, "15.2.3 c",
          "only END_REQ and BEGIN_RESP travel backward");
  if (follow(payload, delay, "backward call") != nullptr) {
    if (phase == tlm::END_REQ) end_request(payload);
    if (response) begin_response(payload, delay);
  }
  const tlm_sync_enum status = target->nb_transport_bw(payload, phase, delay);
  if (!response) {
    require(status == ::tlm::TLM_ACCEPTED, "15.2.3 c", "END_REQ must be answered with TLM_ACCEPTED");
    return status;
  }
  if (status == ::tlm::TLM_UPDATED) {
    require(phase == tlm::END_RESP, "15.2.3 c", "BEGIN_RESP returned a wrong phase");
    end_response(payload, delay);
    finish(payload);
  } else if (status == ::tlm::TLM_COMPLETED) {
    require(!config_.project_rules, "project", "TLM_COMPLETED for BEGIN_RESP hangs DRAMSys 5.1");
    finish(payload);
  }
  return status;
}

void AtProtocolChecker::blocking(tlm_generic_payload& payload, sc_time& delay) {
  const sc_core::sc_process_handle process = sc_core::sc_get_current_process_handle();
  require(process.proc_kind() != sc_core::SC_METHOD_PROC_, "11.1.1.4 b", "b_transport called from an SC_METHOD");
  require(live_.find(&payload) == live_.end(), "15.2.10 c",
          "b_transport with a payload that is in a non-blocking life");
  check_attributes(payload);
  initiator->b_transport(payload, delay);
}

void AtProtocolChecker::begin_request(const tlm_generic_payload& payload, const sc_time& delay) {
  require(live_.find(&payload) == live_.end(), "14.5 x", "payload sent again while it is in use");
  require(request_ == nullptr, "15.2.6 e", "BEGIN_REQ while a request is in its request phase");
  require(payload.has_mm(), "14.5 i", "a payload of a non-blocking call needs a memory manager");
  check_attributes(payload);
  Life life;
  life.command = payload.get_command();
  life.data = payload.get_data_ptr();
  life.length = payload.get_data_length();
  life.streaming_width = payload.get_streaming_width();
  life.byte_enables = payload.get_byte_enable_ptr();
  life.last = sc_core::sc_time_stamp() + delay;
  live_[&payload] = life;
  request_ = &payload;
  ++transactions_;
}

void AtProtocolChecker::check_attributes(const tlm_generic_payload& payload) {
  const unsigned length = payload.get_data_length();
  require(payload.get_data_ptr() != nullptr || payload.get_command() == ::tlm::TLM_IGNORE_COMMAND, "14.11 e",
          "data pointer is null");
  require(length > 0, "14.12 d", "data length is 0");
  require(payload.get_byte_enable_ptr() == nullptr || payload.get_byte_enable_length() > 0, "14.14 f",
          "byte enables of length 0");
  require(payload.get_streaming_width() > 0, "14.15 f", "streaming width is 0");
  require(!payload.is_dmi_allowed(), "14.16", "DMI hint is set in a request");
  require(payload.get_response_status() == ::tlm::TLM_INCOMPLETE_RESPONSE, "14.17 e",
          "response status of a request is not TLM_INCOMPLETE_RESPONSE");
  require(payload.get_gp_option() == ::tlm::TLM_MIN_PAYLOAD, "14.8 g", "generic payload option is not TLM_MIN_PAYLOAD");
  if (!config_.project_rules || length == 0) return;
  require(std::has_single_bit(length), "project", "data length is not a power of two");
  require(payload.get_address() % length == 0, "project", "address is not naturally aligned");
  require(payload.get_streaming_width() == length, "project", "streaming width differs from the length");
  require(config_.address_limit == 0 || lies_below(config_.address_limit, payload.get_address(), length), "project",
          "address beyond the memory");
}

AtProtocolChecker::Life* AtProtocolChecker::follow(const tlm_generic_payload& payload, const sc_time& delay,
                                                   const char* where) {
  const auto found = live_.find(&payload);
  if (found == live_.end()) {
    require(false, "15.2.4", std::string(where) + " for a transaction that is not in progress");
    return nullptr;
  }
  Life& life = found->second;
  require(payload.get_ref_count() >= 1, "14.5 t", std::string(where) + " with reference count 0");
  require(payload.get_command() == life.command && payload.get_data_ptr() == life.data &&
              payload.get_data_length() == life.length && payload.get_streaming_width() == life.streaming_width &&
              payload.get_byte_enable_ptr() == life.byte_enables,
          "14.7", std::string(where) + ": an attribute changed during the life of the transaction");
  const sc_time point = sc_core::sc_time_stamp() + delay;
  require(point >= life.last, "15.2.7 c", std::string(where) + ": time plus delay went back");
  life.last = point;
  return &life;
}

void AtProtocolChecker::end_request(const tlm_generic_payload& payload) {
  Life& life = live_[&payload];
  require(life.state == State::requested, "15.2.4", "END_REQ out of order");
  life.state = State::accepted;
  if (request_ == &payload) request_ = nullptr;
}

void AtProtocolChecker::begin_response(const tlm_generic_payload& payload, const sc_time& delay) {
  Life& life = live_[&payload];
  require(life.state != State::responding, "15.2.4", "second BEGIN_RESP of a transaction");
  require(response_ == nullptr, "15.2.6 f", "BEGIN_RESP while a response is in its response phase");
  require(payload.get_response_status() != ::tlm::TLM_INCOMPLETE_RESPONSE, "14.17", "BEGIN_RESP without a status");
  life.state = State::responding;
  life.response_begun = sc_core::sc_time_stamp() + delay;
  if (request_ == &payload) request_ = nullptr;  // BEGIN_RESP implies END_REQ
  response_ = &payload;
}

void AtProtocolChecker::end_response(const tlm_generic_payload& payload, const sc_time& delay) {
  const auto found = live_.find(&payload);
  if (found == live_.end()) {
    require(false, "15.2.4", "END_RESP for a transaction that is not in progress");
    return;
  }
  const Life& life = found->second;
  const sc_time point = sc_core::sc_time_stamp() + delay;
  require(life.state == State::responding, "15.2.4", "END_RESP without BEGIN_RESP");
  require(point >= life.last, "15.2.7 c", "END_RESP: time plus delay went back");
  const sc_time clock(static_cast<double>(config_.period_fs), sc_core::SC_FS);
  require(!config_.project_rules || point >= life.response_begun + clock, "project",
          "END_RESP less than one clock after BEGIN_RESP");
}

void AtProtocolChecker::finish(const tlm_generic_payload& payload) {
  if (request_ == &payload) request_ = nullptr;
  if (response_ == &payload) response_ = nullptr;
  live_.erase(&payload);
}

}  // namespace grtx::modules
