#include "rtl_tlm/fast/fast_sm.h"

#include <algorithm>

namespace grtx::tlm {

using modules::kNever;
using modules::Link;
using modules::MemoryRequest;
using modules::MemoryResponse;

namespace {

constexpr std::size_t kSimt = 0;  // clients
constexpr std::size_t kCheckpoint = 1;

}  // namespace

FastSm::FastSm(const sc_core::sc_module_name& module_name, const GpuConfig& config, unsigned index,
               const traces::Header& header, const modules::MemoryMap& map, FastMemory& memory)
    : sc_module(module_name),
      clock_("clock", config.core_mhz),
      bundle_(clock_),
      l1_(config.l1, index, config.links.capacity, memory),
      launch_("launch", config.sm_links.message_latency, config.resident_warps),
      ended_("ended", config.sm_links.message_latency, config.resident_warps),
      calls_("calls", config.sm_links.message_latency, config.resident_warps),
      dones_("dones", config.sm_links.message_latency, config.resident_warps),
      batches_("batches", config.sm_links.message_latency, config.resident_warps),
      shader_dones_("shader_dones", config.sm_links.message_latency, config.resident_warps) {
  clock_.set_cycle(0);
  const SmLinks& links = config.sm_links;
  add_client("simt", links);
  FastRtUnit::Links rt{&calls_, &dones_, &batches_, &shader_dones_, nullptr, nullptr};
  if (header.checkpoint) {
    const Client& client = clients_[add_client("checkpoint", links)];
    rt.checkpoint_requests = client.request.get();
    rt.checkpoint_responses = client.response.get();
  }

  modules::SimtCoreConfig core = config.simt;
  core.sm = index;
  core.resident_warps = config.resident_warps;
  core.l1_client = kSimt;
  bundle_.begin();
  simt_ = std::make_unique<modules::SimtCore>("simt", clock_, core, header, map);
  bundle_.end();
  simt_->launch.bind(launch_);
  simt_->ended.bind(ended_);
  simt_->trace_call.bind(calls_);
  simt_->trace_done.bind(dones_);
  simt_->any_hit_batch.bind(batches_);
  simt_->any_hit_done.bind(shader_dones_);
  simt_->memory_request.bind(*clients_[kSimt].request);
  simt_->memory_response.bind(*clients_[kSimt].response);
  rt_ = std::make_unique<FastRtUnit>("rt", config.rt, header, map, index, l1_, rt);
}

std::size_t FastSm::add_client(const std::string& client, const SmLinks& links) {
  Client c;
  c.request = std::make_unique<Link<MemoryRequest>>(client + "_request", links.l1_latency, links.l1_capacity);
  c.response = std::make_unique<Link<MemoryResponse>>(client + "_response", links.l1_latency, links.l1_capacity);
  clients_.push_back(std::move(c));
  return clients_.size() - 1;
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
  if (now >= next_advance_ && now < end) {
    l1_.advance(now);
    rt_->advance(now);
    next_advance_ = now + PortCalendar::kPeriod;
  }
  while (now < end) {
    step(now);
    now = std::max(earliest(), now + 1);
  }
  due_ = now;
}

Cycle FastSm::earliest() const {
  Cycle due = std::min({rt_->due(), bundle_.next(), launch_.next_visible()});
  for (const Client& client : clients_) due = std::min({due, client.ask_due(), client.respond_due()});
  return due;
}

// Only what is due is touched.
void FastSm::step(Cycle now) {
  for (Client& client : clients_) {
    if (client.ask_due() <= now) ask(now, client);
    if (client.respond_due() <= now) respond(now, client);
  }
  if (rt_->due() <= now) rt_->step(now);
  if (bundle_.next() <= now) {
    clock_.set_cycle(now);
    bundle_.run();
    rt_->core_has_run();
  }
}

// A request stays at the head of its link until the L1 takes it, and holds back those behind it.
void FastSm::ask(Cycle now, Client& client) {
  if (client.taken == 0) {
    const MemoryRequest request = *client.request->front(now);
    const bool simt = &client == &clients_[kSimt];
    const FastL1::Access access = l1_.access(now, request, simt ? FastL1::kSimt : FastL1::kCheckpoint);
    if (access.taken == kNever) {
      client.next = access.seen;
      return;
    }
    client.taken = access.taken;
    client.answers.push_back(
        {{request.address, request.tag, request.client, request.sm, request.region, request.write, request.prefetch},
         access.seen - client.response->latency(),
         client.asked++});
    std::push_heap(client.answers.begin(), client.answers.end());
  }
  if (client.taken > now) {
    client.next = client.taken;
    return;
  }
  client.taken = 0;
  client.request->pop(now);
  client.next = now + 1;
  if (clients_.size() > kCheckpoint && &client == &clients_[kCheckpoint]) rt_->client_has_room(now);
}

// As the L1 of the cycle model: one a cycle, what has been due longest first.
void FastSm::respond(Cycle now, Client& client) {
  client.respond_next = now + 1;
  if (!client.response->can_push(now)) return;
  client.response->push(now, client.answers.front().response);
  std::pop_heap(client.answers.begin(), client.answers.end());
  client.answers.pop_back();
  if (clients_.size() > kCheckpoint && &client == &clients_[kCheckpoint]) {
    rt_->response_arrives(now + client.response->latency());
  }
}

bool FastSm::idle() const {
  return rt_->idle() && simt_->idle() && ended_.empty() &&
         std::all_of(clients_.begin(), clients_.end(),
                     [](const Client& c) { return c.request->empty() && c.response->empty() && c.answers.empty(); });
}

}  // namespace grtx::tlm
