// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/noc/crossbar.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/link_inventory.h"

namespace grtx::modules {
namespace {

void require(bool holds, const char* rule) {
  if (!holds) throw Error("configuration", "crossbar", rule);
}

}  // namespace

template <>
unsigned CrossbarNetwork<MemoryRequest>::destination(const MemoryRequest& request) const {
  return interleave_.slice(request.address);
}

template <>
unsigned CrossbarNetwork<MemoryResponse>::destination(const MemoryResponse& response) const {
  return response.sm;
}

// The bodies of the loops are inlined: they run once per packet.
template <typename Packet>
Cycle CrossbarNetwork<Packet>::tick(Cycle now) {
  // Each head packet of an input requests its output.
  const unsigned n = static_cast<unsigned>(inputs_.size());
  Cycle due = kNever;
  waiting_.for_each([&](unsigned i) __attribute__((always_inline)) {
    const Packet* head = inputs_[i].front(now);
    if (head == nullptr) {
      due = std::min(due, inputs_[i].next_visible());
      return;
    }
    const unsigned to = destination(*head);
    Output& output = outputs_[to];
    if (output.buffer.size() >= output.capacity) {
      ++counters_.blocked_cycles;
      due = now + 1;
      return;
    }
    // The input nearest to the round-robin pointer wins.
    const unsigned distance = i >= output.next_input ? i - output.next_input : i + n - output.next_input;
    if (output.contenders++ != 0) {
      ++counters_.conflict_cycles;
      due = now + 1;
      if (distance > output.distance) return;
    }
    output.winner = i;
    output.distance = distance;
    contended_.insert(to);
  });

  contended_.for_each([&](unsigned i) __attribute__((always_inline)) {
    Output& output = outputs_[i];
    output.contenders = 0;
    LinkReader<Packet>& input = inputs_[output.winner];
    Held& held = output.buffer.add();
    held.packet = *input.front(now);
    held.due = now + output.hold;
    if (output.buffer.size() == 1) due_[i] = held.due;
    busy_.insert(i);
    input.pop(now);
    waiting_.popped(output.winner, input);
    due = std::min(due, input.next_visible());
    output.next_input = output.winner + 1 == n ? 0 : output.winner + 1;
    ++counters_.packets_in;
  });
  contended_.clear();

  busy_.for_each([&](unsigned i) __attribute__((always_inline)) {
    if (due_[i] <= now) deliver(now, i);
    due = std::min(due, due_[i]);
  });
  return std::max(due, now + 1);
}

// Moves the output's oldest packet into its link if there is room.
template <typename Packet>
inline void CrossbarNetwork<Packet>::deliver(Cycle now, unsigned i) {
  Output& output = outputs_[i];
  if (!output.link.try_push(now, output.buffer.front().packet)) return;
  output.buffer.pop();
  ++counters_.packets_out;
  due_[i] = output.buffer.empty() ? kNever : output.buffer.front().due;
  if (output.buffer.empty()) busy_.erase(i);
}

template <typename Packet>
bool CrossbarNetwork<Packet>::idle() const {
  return std::all_of(outputs_.begin(), outputs_.end(), [](const Output& output) { return output.buffer.empty(); }) &&
         std::all_of(inputs_.begin(), inputs_.end(), [](const LinkReader<Packet>& link) { return link.empty(); });
}

template <typename Packet>
void CrossbarNetwork<Packet>::dump_state(std::ostream& out) const {
  for (std::size_t i = 0; i < inputs_.size(); ++i) out << " in" << i << ' ' << inputs_[i].size();
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    out << " out" << i << ' ' << outputs_[i].buffer.size();
  }
  out << '\n';
}

Crossbar::Crossbar(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : CrossbarModule(name, config.sms, config.interleave.slices),
      config_(config),
      requests_(clock, config.interleave, config.sms, config.interleave.slices, config.latency, config.output_buffer),
      replies_(clock, config.interleave, config.interleave.slices, config.sms, config.latency, config.output_buffer) {
  require(config.sms >= 1 && config.sms <= 256, "SMs must be 1 to 256");
  require_allowed("crossbar", config);
  config.interleave.check();
}

void Crossbar::end_of_elaboration() {
  const char* too_long = "latency is shorter than that of an output link";
  for (unsigned sm = 0; sm < config_.sms; ++sm) {
    require(response_out[sm]->latency() <= config_.latency, too_long);
    requests_.bind_input(sm, reader_of(request_in[sm]));
    replies_.bind_output(sm, writer_of(response_out[sm]));
  }
  for (unsigned slice = 0; slice < config_.interleave.slices; ++slice) {
    require(request_out[slice]->latency() <= config_.latency, too_long);
    requests_.bind_output(slice, writer_of(request_out[slice]));
    replies_.bind_input(slice, reader_of(response_in[slice]));
  }
}

bool Crossbar::idle() const { return requests_.idle() && replies_.idle(); }

void Crossbar::statistics(StatisticList& list, const std::string& prefix) const { describe(counters(), list, prefix); }

const CounterTable<CrossbarCounters::Network>& CrossbarCounters::Network::table() {
  using C = CrossbarCounters::Network;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::packets_in)
          .sum(&C::packets_out, "packets", "packets", "packets delivered")
          .sum(&C::conflict_cycles, "conflict_cycles", "packet-cycles", "a head packet lost the arbitration")
          .sum(&C::blocked_cycles, "blocked_cycles", "packet-cycles", "a head packet's output buffer was full");
  return table;
}

void describe(const CrossbarCounters& counters, StatisticList& list, const std::string& prefix) {
  counters.request.table().describe(counters.request, list, prefix + ".request");
  counters.reply.table().describe(counters.reply, list, prefix + ".reply");
  counters.own.describe(list, prefix);
}

Inventory Crossbar::inventory() const {
  const std::uint64_t slots = std::uint64_t{config_.latency} + config_.output_buffer;
  const unsigned slices = config_.interleave.slices;
  Inventory inventory;
  inventory.module = this->name();
  inventory.storage = {{"request_buffers", StorageKind::ram, slots * slices * kPacketBits, 1, 1, false},
                       {"reply_buffers", StorageKind::ram, slots * config_.sms * kPacketBits, 1, 1, false}};
  inventory.operators = {{"mux", kPacketBits, std::uint64_t{2} * config_.sms * slices},
                         {"arbiter", config_.sms, slices},
                         {"arbiter", slices, config_.sms}};
  return inventory;
}

void Crossbar::dump_state(std::ostream& out) const {
  out << name() << ": requests";
  requests_.dump_state(out);
  out << name() << ": replies";
  replies_.dump_state(out);
}

template class CrossbarNetwork<MemoryRequest>;
template class CrossbarNetwork<MemoryResponse>;

std::unique_ptr<CrossbarModule> make_crossbar(const sc_core::sc_module_name& name, const CrossbarConfig& config,
                                              ClockDomain& clock) {
  return std::make_unique<Crossbar>(name, config, clock);
}

}  // namespace grtx::modules
