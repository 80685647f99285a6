// SPDX-License-Identifier: Apache-2.0
// Checks the TLM-2.0 AT base protocol on a 32-bit connection; inserted between an initiator and its target.
// Rules and clause numbers of IEEE 1666-2011, plus what DRAM simulators need (DRAMSys 5.1): power-of-two lengths,
// natural alignment, END_RESP at least one clock after BEGIN_RESP and never TLM_COMPLETED instead. Costs one hash
// lookup per call; leave it out if speed matters.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>
#include <cstdint>
#include <string>
#include <systemc>
#include <tlm>
#include <unordered_map>
#include <vector>

namespace grtx::modules {

class AtProtocolChecker final : public sc_core::sc_module {
 public:
  struct Config {
    bool project_rules = true;        ///< also check the rules beyond the standard
    std::uint64_t period_fs = 0;      ///< least time from BEGIN_RESP to END_RESP; 0: not checked
    std::uint64_t address_limit = 0;  ///< addresses must be below; 0: not checked
    std::size_t max_messages = 100;   ///< messages kept; violations beyond are only counted
  };

  AtProtocolChecker(const sc_core::sc_module_name& name, const Config& config);

  tlm_utils::simple_target_socket<AtProtocolChecker, 32> target;        ///< bind the initiator to this
  tlm_utils::simple_initiator_socket<AtProtocolChecker, 32> initiator;  ///< bind this to the target

  std::uint64_t violations() const { return violations_; }
  /// One message per violation: "name @time: clause: what".
  const std::vector<std::string>& messages() const { return messages_; }
  std::uint64_t transactions() const { return transactions_; }  ///< transactions begun
  std::uint64_t outstanding() const { return live_.size(); }    ///< transactions begun and not ended
  /// Another launch begins: forgets counts and messages.
  void restart() {
    violations_ = transactions_ = 0;
    messages_.clear();
  }

 private:
  enum class State : std::uint8_t { requested, accepted, responding };
  struct Life {
    State state = State::requested;
    ::tlm::tlm_command command = ::tlm::TLM_IGNORE_COMMAND;
    unsigned char* data = nullptr;
    unsigned length = 0;
    unsigned streaming_width = 0;
    unsigned char* byte_enables = nullptr;
    sc_core::sc_time last;  ///< timing point of the latest call or return
    sc_core::sc_time response_begun;
  };

  ::tlm::tlm_sync_enum forward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay);
  ::tlm::tlm_sync_enum backward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay);
  void blocking(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  unsigned debug(::tlm::tlm_generic_payload& payload) { return initiator->transport_dbg(payload); }
  bool direct(::tlm::tlm_generic_payload& payload, ::tlm::tlm_dmi& dmi) {
    return initiator->get_direct_mem_ptr(payload, dmi);
  }
  void invalidate(sc_dt::uint64 begin, sc_dt::uint64 end) { target->invalidate_direct_mem_ptr(begin, end); }

  void begin_request(const ::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay);
  void check_attributes(const ::tlm::tlm_generic_payload& payload);
  void end_request(const ::tlm::tlm_generic_payload& payload);
  void begin_response(const ::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay);
  void end_response(const ::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay);
  void finish(const ::tlm::tlm_generic_payload& payload);
  /// Checks the rules that hold on every call and return. Returns nullptr if the transaction is not in progress.
  Life* follow(const ::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay, const char* where);
  void require(bool holds, const char* clause, const std::string& what);

  Config config_;
  std::unordered_map<const ::tlm::tlm_generic_payload*, Life> live_;
  const ::tlm::tlm_generic_payload* request_ = nullptr;   ///< in its request phase
  const ::tlm::tlm_generic_payload* response_ = nullptr;  ///< in its response phase
  std::uint64_t transactions_ = 0;
  std::uint64_t violations_ = 0;
  std::vector<std::string> messages_;
};

}  // namespace grtx::modules
