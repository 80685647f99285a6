// SPDX-License-Identifier: Apache-2.0
// The built-in DRAM: one TLM-2.0 AT target socket per L2 slice, in its own memory clock domain (3500 MHz, Table I);
// slices may share a channel. Holds no data: reads answer zeros, writes change nothing. Channel model in
// dram_channel.h. Costs two calls into the initiator per request; sleeps while nothing changes at its sockets. An
// external DRAM simulator with 32-bit base-protocol sockets can replace it without a source change.
#pragma once

#include <tlm_utils/simple_target_socket.h>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/messages/address_interleave.h"

namespace grtx::modules {

class Dram final : public ClockedModule {
 public:
  using Config = DramConfig;

  /// clock: memory domain. Throws Error for an impossible configuration.
  Dram(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);
  ~Dram() override;

  using Socket = tlm_utils::simple_target_socket_tagged<Dram, 32>;
  sc_core::sc_vector<Socket> sockets;  ///< [slice]; addresses are global, mapped to channel-local ones inside

  Inventory inventory() const;
  void statistics(StatisticList& list, const std::string& prefix) const;
  DramCounters counters() const;
  std::vector<DramChannelCounters> all_channel_counters() const;
  DramChannelCounters channel_counters(unsigned channel) const;
  bool idle() const;
  unsigned channels() const { return config_.interleave.dram_channels(); }
  std::uint64_t outstanding(unsigned channel) const;  ///< requests in flight
  void dump_state(std::ostream& out) const;
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// DRAM, load() a newly constructed one.
  void save(StateWriter& state) const;
  void load(StateReader& state);
  const Config& config() const { return config_; }

 private:
  struct Port;
  struct Channel;

  ::tlm::tlm_sync_enum nb_transport_fw(int id, ::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
  void b_transport(int id, ::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  ::tlm::tlm_sync_enum reject(::tlm::tlm_generic_payload& payload, const char* rule) const;
  ::tlm::tlm_response_status check(unsigned socket, const ::tlm::tlm_generic_payload& payload) const;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  Channel& channel_of(unsigned socket);
  Port& port_of(unsigned socket);
  void answer_unqueued(Channel& channel, Port& port, Cycle now);
  void take_arrival(Channel& channel, Cycle now);
  void end_request(Port& port, ::tlm::tlm_response_status status);
  void begin_response(Channel& channel, Port& port, Cycle now);
  void collect_completions(Channel& channel);
  Cycle next_due(Channel& channel, Cycle now);

  Config config_;
  std::vector<Channel> channels_;
};

}  // namespace grtx::modules
