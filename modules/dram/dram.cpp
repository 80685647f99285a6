#include "grtx/modules/dram/dram.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {

Dram::Dram(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : ClockedModule(name, clock), sockets("socket", config.interleave.slices), config_(config) {
  config.interleave.check();
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    ports_.emplace_back(config.channel);
    sockets[i].register_nb_transport_fw(this, &Dram::nb_transport_fw, static_cast<int>(i));
    sockets[i].register_b_transport(this, &Dram::b_transport, static_cast<int>(i));
  }
}

::tlm::tlm_response_status Dram::check(const ::tlm::tlm_generic_payload& payload) const {
  const std::uint64_t bytes = payload.get_data_length();
  if (payload.get_command() == ::tlm::TLM_IGNORE_COMMAND) return ::tlm::TLM_COMMAND_ERROR_RESPONSE;
  if (payload.get_byte_enable_ptr() != nullptr) return ::tlm::TLM_BYTE_ENABLE_ERROR_RESPONSE;
  // A naturally aligned power of two cannot straddle channels or rows.
  const std::uint64_t longest = std::min(config_.interleave.bytes, config_.channel.bytes_in_row());
  if (!std::has_single_bit(bytes) || bytes > longest || payload.get_streaming_width() < bytes ||
      config_.channel.queue * config_.channel.burst_bytes < bytes) {
    return ::tlm::TLM_BURST_ERROR_RESPONSE;
  }
  if (payload.get_address() % bytes != 0) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  if (config_.bytes != 0 && payload.get_address() + bytes > config_.bytes) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  return ::tlm::TLM_OK_RESPONSE;
}

::tlm::tlm_sync_enum Dram::nb_transport_fw(int id, ::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                           sc_core::sc_time& delay) {
  Port& port = ports_[static_cast<std::size_t>(id)];
  const Cycle edge = clock_.edge_after(delay.value());
  if (phase == tlm::BEGIN_REQ) {
    if (port.arriving != nullptr) SC_REPORT_ERROR("/grtx/dram", "BEGIN_REQ before END_REQ of the previous request");
    payload.acquire();
    port.arriving = &payload;
    port.arrival = edge;
    ++port.outstanding;
  } else if (phase == tlm::END_RESP) {
    if (port.responding != &payload) SC_REPORT_ERROR("/grtx/dram", "END_RESP without BEGIN_RESP");
    port.responding = nullptr;
    port.response_free = edge;
    payload.release();
    if (port.responses.empty()) return ::tlm::TLM_ACCEPTED;  // the clock in which one may be ready is booked
    const Cycle next = std::max(edge, port.responses.front().due);
    port.due = std::min(port.due, next);
    alarm_.request(next);
    return ::tlm::TLM_ACCEPTED;
  } else {
    return ::tlm::TLM_ACCEPTED;  // extended phases are ignored
  }
  port.due = std::min(port.due, edge);
  alarm_.request(edge);
  return ::tlm::TLM_ACCEPTED;
}

// Loosely timed: the unloaded latency of a closed row, no contention.
void Dram::b_transport(int, ::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
  const DramTiming& t = config_.channel.timing;
  const Cycle data = payload.is_write() ? t.activate_to_write() + t.wl : t.rcd + t.cl;
  const Cycle access = config_.perfect ? 0 : data + t.ccd;
  payload.set_response_status(check(payload));
  delay += sc_core::sc_time::from_value((access + config_.fixed_latency) * clock_.period_fs());
}

Cycle Dram::tick(Cycle now) {
  Cycle due = kNever;
  for (unsigned id = 0; id < ports_.size(); ++id) {
    Port& port = ports_[id];
    if (port.due <= now) {
      port.channel.run_until(now - 1);
      collect_completions(port);
      if (port.arriving != nullptr && port.arrival <= now) take_arrival(id, port, now);
      begin_response(id, port, now);
      port.due = next_due(port, now);
    }
    due = std::min(due, port.due);
  }
  return due;
}

void Dram::take_arrival(unsigned id, Port& port, Cycle now) {
  ::tlm::tlm_generic_payload& payload = *port.arriving;
  const ::tlm::tlm_response_status status = check(payload);
  const unsigned bytes = payload.get_data_length();
  if (status != ::tlm::TLM_OK_RESPONSE || config_.perfect) {
    if (status != ::tlm::TLM_OK_RESPONSE) ++port.refused;
    if (config_.perfect) port.channel.count_unqueued(bytes, payload.is_write());
    port.responses.push({&payload, now + config_.fixed_latency});
  } else {
    if (!port.channel.can_accept(bytes)) return;  // next_due() books the clock of the next attempt
    port.channel.enqueue(now, reinterpret_cast<std::uintptr_t>(&payload),
                         config_.interleave.local(payload.get_address()), bytes, payload.is_write());
  }
  payload.set_response_status(status);
  port.arriving = nullptr;
  ::tlm::tlm_phase phase = tlm::END_REQ;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  sockets[id]->nb_transport_bw(payload, phase, delay);
}

void Dram::collect_completions(Port& port) {
  RingQueue<DramChannel::Completion>& completions = port.channel.completions();
  while (!completions.empty()) {
    const DramChannel::Completion& done = completions.front();
    port.responses.push({reinterpret_cast<::tlm::tlm_generic_payload*>(done.id), done.done + config_.fixed_latency});
    completions.pop();
  }
}

void Dram::begin_response(unsigned id, Port& port, Cycle now) {
  if (port.responses.empty() || port.responses.front().due > now) return;
  if (port.responding != nullptr || port.response_free > now) return;
  ::tlm::tlm_generic_payload& payload = *port.responses.front().payload;
  port.responses.pop();
  port.responding = &payload;
  ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  const ::tlm::tlm_sync_enum status = sockets[id]->nb_transport_bw(payload, phase, delay);
  ++port.responded;
  --port.outstanding;
  const bool ended = status == ::tlm::TLM_COMPLETED || (status == ::tlm::TLM_UPDATED && phase == tlm::END_RESP);
  if (!ended || port.responding == nullptr) return;  // END_RESP comes, or came, by a call
  port.responding = nullptr;
  port.response_free = clock_.edge_after(delay.value());
  payload.release();
}

Cycle Dram::next_due(Port& port, Cycle now) {
  Cycle due = kNever;
  if (port.arriving != nullptr) {
    if (port.arrival <= now) {
      // The queue is full, and nothing else can enter it: run ahead to the command that makes room. The request must
      // not be looked at before that clock, because the channel is already there.
      const Cycle room = port.channel.run_until_room(port.arriving->get_data_length()) + 1;
      port.full_clocks += room - port.arrival;
      port.arrival = room;
      collect_completions(port);
    }
    due = port.arrival;
  }
  if (!port.responses.empty()) {
    if (port.responding == nullptr) due = std::min(due, std::max(port.responses.front().due, port.response_free));
  } else if (const Cycle bound = port.channel.completion_bound(); bound != kNever) {
    due = std::min(due, bound + config_.fixed_latency);
  }
  return due == kNever ? kNever : std::max(due, now + 1);
}

DramChannelCounters Dram::channel_counters(unsigned channel) const {
  const Port& port = ports_[channel];
  DramChannelCounters counters = port.channel.counters();
  counters.responses = port.responded;
  counters.refused = port.refused;
  counters.full_clocks = port.full_clocks;
  return counters;
}

std::vector<DramChannelCounters> Dram::all_channel_counters() const {
  std::vector<DramChannelCounters> all;
  for (unsigned i = 0; i < channels(); ++i) all.push_back(channel_counters(i));
  return all;
}

DramCounters Dram::counters() const {
  return dram_counters(config_.channel, all_channel_counters(), clock_.now_fs() / clock_.period_fs());
}

void Dram::statistics(StatisticList& list, const std::string& prefix) const {
  describe(counters(), all_channel_counters(), list, prefix);
}

bool Dram::idle() const {
  return std::all_of(ports_.begin(), ports_.end(),
                     [](const Port& p) { return p.outstanding == 0 && p.responding == nullptr; });
}

Inventory Dram::inventory() const {
  // The memory controllers' part; the DRAM chips are not on the die.
  const unsigned entry_bits = 40 - 5 + 1 + 8 * config_.channel.burst_bytes;
  const unsigned bank_bits = 16 + 1 + 4 * 8 + make_dram_scheduling(config_.channel)->bits_per_bank();
  Inventory inventory;
  inventory.module = this->name();
  inventory.storage = {
      {"queues", StorageKind::ram, ports_.size() * config_.channel.queue * entry_bits, 1, 1, false, entry_bits},
      {"bank_state", StorageKind::flip_flop, ports_.size() * config_.channel.banks * bank_bits, 1, 1, false}};
  inventory.operators = {{"match", 16, ports_.size() * config_.channel.queue}};
  return inventory;
}

void Dram::dump_state(std::ostream& out) const {
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const Port& port = ports_[i];
    out << name() << " channel " << i << ": outstanding " << port.outstanding << ", responses " << port.responses.size()
        << (port.arriving != nullptr ? ", request waiting" : "")
        << (port.responding != nullptr ? ", response open" : "") << '\n';
    port.channel.dump_state(out);
  }
}

}  // namespace grtx::modules
