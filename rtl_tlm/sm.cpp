#include "rtl_tlm/sm.h"

#include <ostream>

#include "rtl_tlm/construction_order.h"

namespace grtx::tlm {

using modules::Link;
using modules::MemoryRequest;
using modules::MemoryResponse;

namespace {

// Ports of the L1. Those that the configuration does not use do not exist: they come last.
constexpr unsigned kNodeClient = 0;
constexpr unsigned kSimtClient = 1;

template <typename T>
std::unique_ptr<Link<T>> link(const std::string& name, unsigned latency, std::size_t capacity) {
  return std::make_unique<Link<T>>(name, latency, capacity);
}

template <typename T>
void dump_link(std::ostream& out, const Link<T>& link) {
  if (!link.empty()) {
    out << "  link " << link.name() << ": " << link.size() << " of " << link.capacity() << ", next visible in cycle "
        << link.next_visible() << '\n';
  }
}

}  // namespace

Sm::Sm(const sc_core::sc_module_name& name, const SmConfig& config, const traces::Header& header,
       const modules::MemoryMap& map, modules::ClockDomain& clock, std::uint64_t order)
    : sc_module(name), processes_(clock) {
  const std::string prefix = std::string(this->name()) + '.';
  const SmLinks& links = config.links;
  trace_call_ = link<modules::TraceCall>(prefix + "trace_call", links.message_latency, config.resident_warps);
  trace_done_ = link<modules::TraceDone>(prefix + "trace_done", links.message_latency, config.resident_warps);
  any_hit_batch_ = link<modules::AnyHitBatch>(prefix + "any_hit_batch", links.message_latency, config.resident_warps);
  any_hit_done_ = link<modules::AnyHitDone>(prefix + "any_hit_done", links.message_latency, config.resident_warps);

  std::vector<std::string> clients = {"rt_node", "simt"};
  if (header.checkpoint) clients.push_back("rt_checkpoint");
  if (config.rt.sibling_prefetch) clients.push_back("rt_prefetch");
  for (const std::string& client : clients) {
    requests_.push_back(link<MemoryRequest>(prefix + client + "_request", links.l1_latency, links.l1_capacity));
    responses_.push_back(link<MemoryResponse>(prefix + client + "_response", links.l1_latency, links.l1_capacity));
  }

  modules::SimtCoreConfig simt = config.simt;
  simt.sm = config.index;
  simt.resident_warps = config.resident_warps;
  simt.l1_client = static_cast<std::uint8_t>(kSimtClient);
  modules::L1Cache::Config l1 = config.l1;
  l1.sm = static_cast<std::uint8_t>(config.index);
  l1.clients = static_cast<unsigned>(clients.size());
  processes_.begin();
  construct({[&] { simt_ = std::make_unique<modules::SimtCore>("simt", clock, simt, header, map); },
             [&] { rt_ = std::make_unique<RtUnit>("rt", config.rt, header, map, clock, config.index); },
             [&] { l1_ = std::make_unique<modules::L1Cache>("l1d", l1, clock); }},
            order);
  processes_.end();
  SC_METHOD(run_parts);
  sensitive << processes_.event();
  dont_initialize();

  simt_->launch.bind(launch);
  simt_->ended.bind(ended);
  simt_->trace_call.bind(*trace_call_);
  rt_->trace_call.bind(*trace_call_);
  rt_->trace_done.bind(*trace_done_);
  simt_->trace_done.bind(*trace_done_);
  rt_->any_hit_batch.bind(*any_hit_batch_);
  simt_->any_hit_batch.bind(*any_hit_batch_);
  simt_->any_hit_done.bind(*any_hit_done_);
  rt_->any_hit_done.bind(*any_hit_done_);

  for (unsigned i = 0; i < clients.size(); ++i) {
    l1_->request[i].bind(*requests_[i]);
    l1_->response[i].bind(*responses_[i]);
  }
  rt_->node_request.bind(*requests_[kNodeClient]);
  rt_->node_response.bind(*responses_[kNodeClient]);
  simt_->memory_request.bind(*requests_[kSimtClient]);
  simt_->memory_response.bind(*responses_[kSimtClient]);
  unsigned next = kSimtClient + 1;
  if (header.checkpoint) {
    rt_->checkpoint_request.bind(*requests_[next]);
    rt_->checkpoint_response.bind(*responses_[next]);
    ++next;
  }
  if (config.rt.sibling_prefetch) {
    rt_->prefetch_request.bind(*requests_[next]);
    rt_->prefetch_response.bind(*responses_[next]);
  }
  l1_->to_memory.bind(to_memory);
  l1_->from_memory.bind(from_memory);
}

bool Sm::idle() const {
  bool idle = simt_->idle() && rt_->idle() && l1_->idle() && trace_call_->empty() && trace_done_->empty() &&
              any_hit_batch_->empty() && any_hit_done_->empty();
  for (const auto& request : requests_) idle = idle && request->empty();
  for (const auto& response : responses_) idle = idle && response->empty();
  return idle;
}

std::uint64_t Sm::progress() const {
  std::uint64_t sum = rt_->progress() + trace_call_->pushed() + any_hit_done_->pushed();
  for (const auto& request : requests_) sum += request->pushed();
  for (const auto& response : responses_) sum += response->pushed();
  return sum;
}

std::vector<modules::Inventory> Sm::inventory() const {
  std::vector<modules::Inventory> parts = rt_->inventory();
  parts.push_back(simt_->inventory());
  parts.push_back(l1_->inventory());
  return parts;
}

void Sm::dump_state(std::ostream& out) const {
  out << name() << '\n';
  dump_link(out, *trace_call_);
  dump_link(out, *trace_done_);
  dump_link(out, *any_hit_batch_);
  dump_link(out, *any_hit_done_);
  for (const auto& request : requests_) dump_link(out, *request);
  for (const auto& response : responses_) dump_link(out, *response);
  simt_->dump_state(out);
  rt_->dump_state(out);
  l1_->dump_state(out);
}

}  // namespace grtx::tlm
