#include "rtl_tlm/fast/fast_sm.h"

#include <algorithm>

namespace grtx::tlm {

using modules::kNever;
using modules::Link;
using modules::MemoryRequest;
using modules::MemoryResponse;

namespace {

constexpr std::size_t kPrefetchResponses = 256;  // only counted; never makes the L1 wait

}  // namespace

FastSm::FastSm(const sc_core::sc_module_name& module_name, const GpuConfig& config, unsigned index,
               const traces::Header& header, const modules::MemoryMap& map, FastMemory& memory)
    : sc_module(module_name),
      clock_("clock", config.core_mhz),
      bundle_(clock_),
      rotating_(config.l1.rotating_priority),
      l1_(config.l1, index, config.links.capacity, memory),
      replies_(memory.replies(index)),
      launch_("launch", config.sm_links.message_latency, config.resident_warps),
      ended_("ended", config.sm_links.message_latency, config.resident_warps),
      calls_("calls", config.sm_links.message_latency, config.resident_warps),
      dones_("dones", config.sm_links.message_latency, config.resident_warps),
      batches_("batches", config.sm_links.message_latency, config.resident_warps),
      shader_dones_("shader_dones", config.sm_links.message_latency, config.resident_warps) {
  clock_.set_cycle(0);
  const SmLinks& links = config.sm_links;
  clients_.emplace_back();
  const unsigned simt_client = add_client("simt", links, links.l1_capacity);
  FastRtUnit::Links rt{&calls_, &dones_, &batches_, &shader_dones_, nullptr, nullptr, nullptr, nullptr};
  if (header.checkpoint) {
    const Client& client = clients_[add_client("checkpoint", links, links.l1_capacity)];
    rt_client_ = clients_.size() - 1;
    rt.checkpoint_requests = client.request.get();
    rt.checkpoint_responses = client.response.get();
  }
  if (config.rt.sibling_prefetch) {
    const Client& client = clients_[add_client("prefetch", links, kPrefetchResponses)];
    rt.prefetch_requests = client.request.get();
    rt.prefetch_responses = client.response.get();
  }

  modules::SimtCoreConfig core = config.simt;
  core.sm = index;
  core.resident_warps = config.resident_warps;
  core.l1_client = static_cast<std::uint8_t>(simt_client);
  bundle_.begin();
  simt_ = std::make_unique<modules::SimtCore>("simt", clock_, core, header, map);
  bundle_.end();
  simt_->launch.bind(launch_);
  simt_->ended.bind(ended_);
  simt_->trace_call.bind(calls_);
  simt_->trace_done.bind(dones_);
  simt_->any_hit_batch.bind(batches_);
  simt_->any_hit_done.bind(shader_dones_);
  simt_->memory_request.bind(*clients_[simt_client].request);
  simt_->memory_response.bind(*clients_[simt_client].response);
  rt_ = std::make_unique<FastRtUnit>("rt", config.rt, header, map, index, kNode, l1_, rt);
}

unsigned FastSm::add_client(const std::string& client, const SmLinks& links, std::size_t responses) {
  Client c;
  c.request = std::make_unique<Link<MemoryRequest>>(client + "_request", links.l1_latency, links.l1_capacity);
  c.response = std::make_unique<Link<MemoryResponse>>(client + "_response", links.l1_latency, responses);
  clients_.push_back(std::move(c));
  return static_cast<unsigned>(clients_.size() - 1);
}

bool FastSm::take_ended(Cycle end, Cycle& seen, std::uint16_t& slot) {
  seen = ended_.next_visible();
  if (seen >= end) return false;
  slot = ended_.front(seen)->slot;
  ended_.pop(seen);
  return true;
}

void FastSm::run(Cycle end) {
  Cycle now = next_due();
  while (now < end) {
    step(now);
    now = std::max(earliest(), now + 1);
  }
  due_ = now;
}

Cycle FastSm::earliest() const {
  Cycle due = std::min({rt_->ask_due(), rt_->due(), bundle_.next(), launch_.next_visible()});
  if (!replies_.empty()) due = std::min(due, replies_.front().due);
  for (const Client& client : clients_) due = std::min({due, client.ask_due, client.respond_due});
  return due;
}

// Only what is due is touched: most steps move one request.
void FastSm::step(Cycle now) {
  if (!replies_.empty() && replies_.front().due <= now) take_reply(now);
  ask_all(now);
  const std::size_t n = clients_.size();
  for (std::size_t i = 1; i < n; ++i) {
    if (clients_[i].respond_due <= now) respond(now, clients_[i]);
  }
  if (rt_->due() <= now) {
    rt_->step(now);
    for (std::size_t i = 2; i < n; ++i) clients_[i].request_changed();
  }
  if (bundle_.next() <= now) {
    clock_.set_cycle(now);
    bundle_.run();
    clients_[kSimt].request_changed();
    rt_->core_has_run();
  }
}

// Banks go to the clients in turn, as in the L1 of the cycle model.
void FastSm::ask_all(Cycle now) {
  const unsigned n = static_cast<unsigned>(clients_.size());
  const unsigned first = first_client_;
  bool won = false;
  for (unsigned k = 0; k < n; ++k) {
    const unsigned i = first + k < n ? first + k : first + k - n;
    if ((i == kNode ? rt_->ask_due() : clients_[i].ask_due) > now) continue;
    const bool accepted = i == kNode ? rt_->ask(now) : ask(now, clients_[i], static_cast<std::uint8_t>(i));
    if (accepted && !won) {
      won = true;
      if (rotating_) first_client_ = i + 1 == n ? 0 : i + 1;
    }
  }
}

void FastSm::take_reply(Cycle now) {
  const MemoryResponse reply = replies_.front().response;
  replies_.pop();
  const auto wait = [&](Client& client, const MemoryResponse& response) {
    client.fills.push({response, now});
    client.response_changed();
  };
  if (reply.write) {
    l1_.acknowledge();
    wait(clients_[reply.client], reply);
  } else {
    l1_.fill(now, reply, [&](const modules::MshrWaiter& w, std::uint64_t address) {
      if (w.client == kNode) {
        rt_->filled(now, w.tag);
      } else {
        wait(clients_[w.client], {address, w.tag, w.client, w.sm, w.region, w.write, w.prefetch});
      }
    });
  }
  rt_->wake(now);
  for (Client& client : clients_) {
    if (client.next != kNever) continue;
    client.next = now;
    client.request_changed();
  }
}

bool FastSm::ask(Cycle now, Client& client, std::uint8_t number) {
  MemoryRequest request = *client.request->front(now);
  request.client = number;
  const FastL1::Outcome outcome = l1_.access(now, request);
  if (outcome == FastL1::Outcome::conflict || outcome == FastL1::Outcome::refused) {
    client.ask_due = client.next = outcome == FastL1::Outcome::refused ? l1_.retry_at() : now + 1;
    return false;
  }
  if (outcome == FastL1::Outcome::hit) {
    client.hits.push(
        {{request.address, request.tag, number, request.sm, request.region, request.write, request.prefetch},
         now + l1_.latency() - client.response->latency()});
    client.response_changed();
  }
  client.request->pop(now);
  client.next = now + 1;
  client.request_changed();
  if (number != kSimt) rt_->client_has_room(now);
  return true;
}

// As the L1 of the cycle model: one a cycle, what has been due longest first.
void FastSm::respond(Cycle now, Client& client) {
  if (!client.response->can_push(now)) {
    client.respond_due = now + 1;
    return;
  }
  const Cycle hit = client.hits.empty() ? kNever : client.hits.front().due;
  const Cycle filled = client.fills.empty() ? kNever : client.fills.front().due;
  modules::RingQueue<Pending>& queue = hit <= filled ? client.hits : client.fills;
  client.response->push(now, queue.front().response);
  queue.pop();
  client.response_changed();
  client.respond_due = std::max(client.respond_due, now + 1);
  if (&client == &clients_[rt_client_]) rt_->response_arrives(now + client.response->latency());
}

bool FastSm::idle() const {
  bool idle = rt_->idle() && simt_->idle() && l1_.idle() && replies_.empty() && ended_.empty();
  for (std::size_t i = 1; i < clients_.size(); ++i) {
    const Client& c = clients_[i];
    idle = idle && c.request->empty() && c.response->empty() && c.hits.empty() && c.fills.empty();
  }
  return idle;
}

}  // namespace grtx::tlm
