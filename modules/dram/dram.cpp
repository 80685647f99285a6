// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/dram/dram.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/origin_extension.h"
#include "grtx/modules/tlm/target_rules.h"

namespace grtx::modules {

/// Transactions in progress at a socket.
struct Dram::Port {
  struct Response {
    ::tlm::tlm_generic_payload* payload = nullptr;
    Cycle due = 0;
  };
  unsigned socket = 0;
  ::tlm::tlm_generic_payload* arriving = nullptr;  ///< in its request phase
  Cycle arrival = 0;                               ///< first clock in which `arriving` is visible
  RingQueue<Response> responses;
  ::tlm::tlm_generic_payload* responding = nullptr;  ///< in its response phase
  Cycle response_free = 0;                           ///< first clock in which the next response may begin
  std::uint64_t outstanding = 0;
};

struct Dram::Channel {
  Channel(const DramChannelConfig& config, std::size_t slices) : channel(config), ports(slices) {}
  DramChannel channel;
  std::vector<Port> ports;  ///< one per slice that shares the channel
  std::size_t turn = 0;     ///< port with the first turn
  bool held = false;        ///< the request of port `turn` waits for room; no other may pass it
  Cycle due = kNever;
  std::uint64_t responded = 0;  ///< responses begun
  std::uint64_t refused = 0;
  std::uint64_t full_clocks = 0;
};

Dram::~Dram() = default;

Dram::Channel& Dram::channel_of(unsigned socket) { return channels_[config_.interleave.channel(socket)]; }

Dram::Port& Dram::port_of(unsigned socket) { return channel_of(socket).ports[socket / channels_.size()]; }

void Dram::save(StateWriter& state) const {
  for (const Channel& channel : channels_) channel.channel.save(state);
}

void Dram::load(StateReader& state) {
  for (Channel& channel : channels_) channel.channel.load(state);
}

Dram::Dram(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : ClockedModule(name, clock), sockets("socket", config.interleave.slices), config_(config) {
  config.interleave.check();
  for (unsigned i = 0; i < config.interleave.dram_channels(); ++i) {
    channels_.emplace_back(config.channel, config.interleave.slices_a_channel());
  }
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    port_of(i).socket = i;
    sockets[i].register_nb_transport_fw(this, &Dram::nb_transport_fw, static_cast<int>(i));
    sockets[i].register_b_transport(this, &Dram::b_transport, static_cast<int>(i));
  }
}

::tlm::tlm_response_status Dram::check(unsigned socket, const ::tlm::tlm_generic_payload& payload) const {
  const std::uint64_t bytes = payload.get_data_length();
  if (const auto refused = common_refusal(payload); refused != ::tlm::TLM_OK_RESPONSE) return refused;
  // A naturally aligned power of two cannot straddle channels or rows.
  const std::uint64_t longest = std::min(config_.interleave.bytes, config_.channel.bytes_in_row());
  if (!std::has_single_bit(bytes) || bytes > longest || payload.get_streaming_width() < bytes ||
      config_.channel.queue * config_.channel.burst_bytes < bytes) {
    return ::tlm::TLM_BURST_ERROR_RESPONSE;
  }
  if (payload.get_address() % bytes != 0) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  const std::uint64_t limit = config_.bytes != 0 ? config_.bytes : ~std::uint64_t{0};
  if (!lies_below(limit, payload.get_address(), bytes)) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  const AddressInterleave& map = config_.interleave;  // a response finds its socket by the address
  const bool shared = map.slices_a_channel() > 1;
  if (shared && map.slice(payload.get_address()) != socket) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  return ::tlm::TLM_OK_RESPONSE;
}

::tlm::tlm_sync_enum Dram::nb_transport_fw(int id, ::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                           sc_core::sc_time& delay) {
  Channel& channel = channel_of(static_cast<unsigned>(id));
  Port& port = port_of(static_cast<unsigned>(id));
  const Cycle edge = clock_.edge_after(delay.value());
  if (phase == tlm::BEGIN_REQ) {
    if (port.arriving != nullptr) return reject(payload, "BEGIN_REQ before END_REQ of the previous request");
    payload.acquire();
    port.arriving = &payload;
    port.arrival = edge;
    ++port.outstanding;
  } else if (phase == tlm::END_RESP) {
    if (port.responding != &payload) return reject(payload, "END_RESP without BEGIN_RESP");
    port.responding = nullptr;
    port.response_free = edge;
    payload.release();
    if (port.responses.empty()) return ::tlm::TLM_ACCEPTED;  // next_due() has booked the clock of the next response
    const Cycle next = std::max(edge, port.responses.front().due);
    channel.due = std::min(channel.due, next);
    alarm_.request(next);
    return ::tlm::TLM_ACCEPTED;
  } else {
    return ::tlm::TLM_ACCEPTED;  // extended phases are ignored
  }
  channel.due = std::min(channel.due, edge);
  alarm_.request(edge);
  return ::tlm::TLM_ACCEPTED;
}

// A report may be configured not to throw; the call then changes nothing here, and the caller gets an error status.
::tlm::tlm_sync_enum Dram::reject(::tlm::tlm_generic_payload& payload, const char* rule) const {
  SC_REPORT_ERROR("/grtx/dram", (std::string(name()) + ": " + rule).c_str());
  payload.set_response_status(::tlm::TLM_GENERIC_ERROR_RESPONSE);
  return ::tlm::TLM_COMPLETED;
}

// Loosely timed: the unloaded latency of a closed row, no contention.
void Dram::b_transport(int id, ::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
  const DramTiming& t = config_.channel.timing;
  const Cycle data = payload.is_write() ? t.activate_to_write() + t.wl : t.rcd + t.cl;
  const Cycle access = config_.perfect ? 0 : data + t.ccd;
  payload.set_response_status(check(static_cast<unsigned>(id), payload));
  read_zeros(payload);
  delay += sc_core::sc_time::from_value((access + config_.fixed_latency) * clock_.period_value());
}

void Dram::restart(Caches caches) {
  for (Channel& channel : channels_) {
    channel.channel.restart(caches == Caches::warm);
    for (Port& port : channel.ports) port.arrival = port.response_free = 0;
    channel.turn = 0;
    channel.held = false;
    channel.due = kNever;
    channel.responded = channel.refused = channel.full_clocks = 0;
  }
}

Cycle Dram::tick(Cycle now) {
  Cycle due = kNever;
  for (Channel& channel : channels_) {
    if (channel.due <= now) {
      channel.channel.run_until(now - 1);
      collect_completions(channel);
      for (Port& port : channel.ports) answer_unqueued(channel, port, now);
      take_arrival(channel, now);
      for (Port& port : channel.ports) begin_response(channel, port, now);
      channel.due = next_due(channel, now);
    }
    due = std::min(due, channel.due);
  }
  return due;
}

// Answers requests that never enter the queue: malformed ones, and all requests of a perfect memory.
void Dram::answer_unqueued(Channel& channel, Port& port, Cycle now) {
  if (port.arriving == nullptr || port.arrival > now) return;
  const ::tlm::tlm_generic_payload& payload = *port.arriving;
  const ::tlm::tlm_response_status status = check(port.socket, payload);
  if (status == ::tlm::TLM_OK_RESPONSE && !config_.perfect) return;
  if (status != ::tlm::TLM_OK_RESPONSE) ++channel.refused;
  if (config_.perfect) channel.channel.count_unqueued(payload.get_data_length(), payload.is_write());
  port.responses.push({port.arriving, now + config_.fixed_latency});
  end_request(port, status);
}

// Accepts one request per clock. Ports take turns; a port whose request finds no room keeps its turn.
void Dram::take_arrival(Channel& channel, Cycle now) {
  const auto arrived = [now](const Port& port) { return port.arriving != nullptr && port.arrival <= now; };
  const std::size_t ports = channel.ports.size();
  for (std::size_t i = 0; i < ports && !channel.held && !arrived(channel.ports[channel.turn]); ++i) {
    channel.turn = (channel.turn + 1) % ports;
  }
  Port& port = channel.ports[channel.turn];
  if (!arrived(port)) return;
  const ::tlm::tlm_generic_payload& payload = *port.arriving;
  const unsigned bytes = payload.get_data_length();
  channel.held = !channel.channel.can_accept(bytes);
  if (channel.held) return;  // next_due() books the clock of the next attempt
  const AddressInterleave& map = config_.interleave;
  channel.channel.enqueue(now, reinterpret_cast<std::uintptr_t>(port.arriving),
                          map.in_channel(map.local(payload.get_address()), port.socket), bytes, payload.is_write(),
                          origin_of(payload));
  channel.turn = (channel.turn + 1) % ports;
  end_request(port, ::tlm::TLM_OK_RESPONSE);
}

void Dram::end_request(Port& port, ::tlm::tlm_response_status status) {
  ::tlm::tlm_generic_payload& payload = *port.arriving;
  payload.set_response_status(status);
  port.arriving = nullptr;
  ::tlm::tlm_phase phase = tlm::END_REQ;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  sockets[port.socket]->nb_transport_bw(payload, phase, delay);
}

void Dram::collect_completions(Channel& channel) {
  RingQueue<DramChannel::Completion>& completions = channel.channel.completions();
  while (!completions.empty()) {
    const DramChannel::Completion& done = completions.front();
    auto* const payload = reinterpret_cast<::tlm::tlm_generic_payload*>(done.id);
    Port& port =
        channel.ports.size() == 1 ? channel.ports.front() : port_of(config_.interleave.slice(payload->get_address()));
    port.responses.push({payload, done.done + config_.fixed_latency});
    completions.pop();
  }
}

void Dram::begin_response(Channel& channel, Port& port, Cycle now) {
  if (port.responses.empty() || port.responses.front().due > now) return;
  if (port.responding != nullptr || port.response_free > now) return;
  ::tlm::tlm_generic_payload& payload = *port.responses.front().payload;
  port.responses.pop();
  port.responding = &payload;
  read_zeros(payload);
  ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  const ::tlm::tlm_sync_enum status = sockets[port.socket]->nb_transport_bw(payload, phase, delay);
  ++channel.responded;
  --port.outstanding;
  const bool ended = status == ::tlm::TLM_COMPLETED || (status == ::tlm::TLM_UPDATED && phase == tlm::END_RESP);
  if (!ended || port.responding == nullptr) return;  // END_RESP will come, or came, as a forward call
  port.responding = nullptr;
  port.response_free = clock_.edge_after(delay.value());
  payload.release();
}

Cycle Dram::next_due(Channel& channel, Cycle now) {
  if (channel.held && channel.ports[channel.turn].arrival <= now) {
    // The queue is full, and nothing else can enter it: run ahead to the command that makes room. The request cannot be
    // accepted before that clock, because the channel has already been simulated up to it.
    Port& port = channel.ports[channel.turn];
    port.arrival = channel.channel.run_until_room(port.arriving->get_data_length()) + 1;
    channel.full_clocks += port.arrival - now;
    collect_completions(channel);
  }
  Cycle due = kNever;
  bool answered = true;  // all ports have waiting responses, which precede the channel's completions
  for (const Port& port : channel.ports) {
    if (port.arriving != nullptr && !(channel.held && port.arrival <= now)) due = std::min(due, port.arrival);
    if (port.responses.empty()) {
      answered = false;
    } else if (port.responding == nullptr) {
      due = std::min(due, std::max(port.responses.front().due, port.response_free));
    }
  }
  if (const Cycle bound = answered ? kNever : channel.channel.completion_bound(); bound != kNever) {
    due = std::min(due, bound + config_.fixed_latency);
  }
  return due == kNever ? kNever : std::max(due, now + 1);
}

std::uint64_t Dram::outstanding(unsigned channel) const {
  std::uint64_t sum = 0;
  for (const Port& port : channels_[channel].ports) sum += port.outstanding;
  return sum;
}

DramChannelCounters Dram::channel_counters(unsigned channel) const {
  const Channel& c = channels_[channel];
  DramChannelCounters counters = c.channel.counters();
  counters.responses = c.responded;
  counters.refused = c.refused;
  counters.full_clocks = c.full_clocks;
  return counters;
}

std::vector<DramChannelCounters> Dram::all_channel_counters() const {
  std::vector<DramChannelCounters> all;
  for (unsigned i = 0; i < channels(); ++i) all.push_back(channel_counters(i));
  return all;
}

DramCounters Dram::counters() const {
  return dram_counters(config_.channel, all_channel_counters(), clock_.cycle_at(clock_.now_fs()));
}

void Dram::statistics(StatisticList& list, const std::string& prefix) const {
  describe(counters(), all_channel_counters(), list, prefix);
}

bool Dram::idle() const {
  const auto quiet = [](const Port& p) { return p.outstanding == 0 && p.responding == nullptr; };
  return std::all_of(channels_.begin(), channels_.end(), [quiet](const Channel& channel) {
    return std::all_of(channel.ports.begin(), channel.ports.end(), quiet);
  });
}

Inventory Dram::inventory() const {
  // Only the memory controllers; the DRAM chips are not on the die.
  const unsigned entry_bits = 40 - 5 + 1 + 8 * config_.channel.burst_bytes;
  const unsigned bank_bits = 16 + 1 + 4 * 8 + channels_.front().channel.scheduling_bits_per_bank();
  Inventory inventory;
  inventory.module = this->name();
  inventory.storage = {
      {"queues", StorageKind::ram, channels_.size() * config_.channel.queue * entry_bits, 1, 1, false, entry_bits},
      {"bank_state", StorageKind::flip_flop, channels_.size() * config_.channel.banks * bank_bits, 1, 1, false}};
  inventory.operators = {{"match", 16, channels_.size() * config_.channel.queue}};
  if (const unsigned slices = config_.interleave.slices_a_channel(); slices > 1) {
    inventory.operators.push_back({"arbiter", slices, channels_.size()});
  }
  return inventory;
}

void Dram::dump_state(std::ostream& out) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    for (const Port& port : channels_[i].ports) {
      out << name() << " channel " << i << ", socket " << port.socket << ": outstanding " << port.outstanding
          << ", responses " << port.responses.size() << (port.arriving != nullptr ? ", request waiting" : "")
          << (port.responding != nullptr ? ", response open" : "") << '\n';
    }
    channels_[i].channel.dump_state(out);
  }
}

}  // namespace grtx::modules
