// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/sm.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <ostream>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/kernel/factory.h"
#include "grtx/modules/kernel/link_inventory.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/construction_order.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"

namespace grtx::sim {

using modules::Link;
using modules::MemoryRequest;
using modules::MemoryResponse;

namespace {

template <typename T>
std::unique_ptr<Link<T>> link(const std::string& name, unsigned latency, std::size_t capacity) {
  return std::make_unique<Link<T>>(name, latency, capacity);
}

template <typename T, typename From, typename To>
void connect(Link<T>& link, From& from, To& to) {
  from.bind(link);
  to.bind(link);
}

/// Names of the first RT unit's parts carry no number: most SMs have one.
std::string numbered(const std::string& name, unsigned unit) { return unit == 0 ? name : name + std::to_string(unit); }

/// The factory of the units at the node ports: the user's, or a unit of the project that the configuration asks for.
decltype(SmParts::node_port) node_port_of(const SmConfig& config, const SmParts& parts) {
  if (parts.node_port && config.rt.memory.by_shader) {
    throw Error("parts", "node_port", "needs rt.memory.by_shader = false: the RT unit has no node port");
  }
  if (parts.node_port && config.rt.memory.asks_at_once()) {
    throw Error("parts", "node_port", "needs rt.memory.l1_hit_latency = 10000: else the L1 is asked past it");
  }
  return parts.node_port;
}

}  // namespace

Sm::Sm(const sc_core::sc_module_name& name, const SmConfig& config, const traces::Header& header,
       const modules::MemoryMap& map, modules::ClockDomain& clock, std::uint64_t order, const SmParts& parts)
    : sc_module(name), at_once_(config.rt.memory.asks_at_once()) {
  const unsigned units = config.rt_units;
  make_rt_links(config);
  const L1Clients clients = l1_clients(config, header);
  make_l1_links(config, clients);

  modules::SimtCoreConfig simt = config.simt;
  simt.sm = config.index;
  simt.resident_warps = config.resident_warps;
  simt.l1_client = clients.simt;
  simt.heap = config.rt.heaps(header);
  modules::L1CacheConfig l1 = config.l1;
  l1.sm = static_cast<std::uint8_t>(config.index);
  l1.clients = static_cast<unsigned>(clients.names.size());
  l1.widths = clients.widths;
  rt_.resize(units);
  modules::RtUnitParts rt_parts = parts.rt_parts;
  use_rtl(config.rt, rt_parts);
  std::vector<std::function<void()>> builders;
  builders.push_back([&] {
    simt_ = modules::made<modules::SimtCore>(parts.simt_core, "simt_core", "simt", clock, simt, header, map);
  });
  for (unsigned u = 0; u < units; ++u) {
    builders.push_back([&, u] {
      const std::string unit = numbered("rt", u);
      rt_[u] =
          parts.rt_unit
              ? modules::not_null(parts.rt_unit(unit.c_str(), config.rt, header, map, clock, config.index), "rt_unit")
              : std::make_unique<modules::RtUnit>(unit.c_str(), config.rt, header, map, clock, config.index, rt_parts);
    });
  }
  if (const auto make = node_port_of(config, parts)) {
    node_ports_.resize(units);
    for (unsigned u = 0; u < units; ++u) {
      builders.push_back([&, u, make] {
        node_ports_[u] = modules::not_null(make(numbered("node_port", u).c_str(), clock), "node_port");
      });
    }
  }
  builders.push_back([&] { l1_ = modules::made<modules::L1Cache>(parts.l1_cache, "l1_cache", "l1d", l1, clock); });
  construct(std::move(builders), order);

  simt_->launch.bind(launch);
  simt_->ended.bind(ended);
  for (unsigned u = 0; u < units; ++u) bind_rt_unit(u, clients.names);
  for (unsigned i = 0; i < clients.names.size(); ++i) {
    l1_->request[i].bind(*requests_[i]);
    l1_->response[i].bind(*responses_[i]);
  }
  simt_->memory_request.bind(*requests_[clients.simt]);
  simt_->memory_response.bind(*responses_[clients.simt]);
  l1_->to_memory.bind(to_memory);
  l1_->from_memory.bind(from_memory);
}

void Sm::make_rt_links(const SmConfig& config) {
  const SmLinks& links = config.links;
  for (unsigned u = 0; u < config.rt_units; ++u) {
    const auto name_of = [&](const char* link) { return numbered(link, u); };
    RtLinks rt;
    const std::size_t warps = config.resident_warps;
    rt.trace_call = link<modules::TraceCall>(name_of("trace_call"), links.message_latency, warps);
    rt.trace_done = link<modules::TraceDone>(name_of("trace_done"), links.message_latency, warps);
    rt.any_hit_batch = link<modules::AnyHitBatch>(name_of("any_hit_batch"), links.message_latency, warps);
    rt.any_hit_done = link<modules::AnyHitDone>(name_of("any_hit_done"), links.message_latency, warps);
    if (config.rt.memory.by_shader) {
      rt.node_fetch = link<modules::NodeFetchBatch>(name_of("node_fetch"), links.message_latency, warps);
      rt.node_fetch_done = link<modules::NodeFetchDone>(name_of("node_fetch_done"), links.message_latency, warps);
    }
    rt_links_.push_back(std::move(rt));
  }
}

Sm::L1Clients Sm::l1_clients(const SmConfig& config, const traces::Header& header) {
  L1Clients clients;
  const auto add = [&clients](const std::string& client, unsigned width) {
    clients.names.push_back(client);
    clients.widths.push_back(width);
  };
  const std::vector<modules::RtL1Client> of_rt = config.rt.l1_clients(header);
  const auto second = std::find_if_not(of_rt.begin(), of_rt.end(), [](const auto& client) { return client.first; });
  for (unsigned u = 0; u < config.rt_units; ++u) {
    for (auto client = of_rt.begin(); client != second; ++client) add(numbered(client->name, u), client->width);
    if (u == 0) {
      clients.simt = static_cast<std::uint8_t>(clients.names.size());
      add("simt", config.simt.sectors_per_cycle);
    }
    for (auto client = second; client != of_rt.end(); ++client) add(numbered(client->name, u), client->width);
  }
  return clients;
}

void Sm::make_l1_links(const SmConfig& config, const L1Clients& clients) {
  for (std::size_t i = 0; i < clients.names.size(); ++i) {
    const std::size_t capacity = config.links.l1_capacity * clients.widths[i];
    requests_.push_back(link<MemoryRequest>(clients.names[i] + "_request", config.links.l1_latency, capacity));
    responses_.push_back(link<MemoryResponse>(clients.names[i] + "_response", config.links.l1_latency, capacity));
  }
}

void Sm::bind_rt_unit(unsigned u, const std::vector<std::string>& clients) {
  modules::RtUnitModule& rt = *rt_[u];
  RtLinks& links = rt_links_[u];
  connect(*links.trace_call, simt_->trace_call, rt.trace_call);
  connect(*links.trace_done, rt.trace_done, simt_->trace_done);
  connect(*links.any_hit_batch, rt.any_hit_batch, simt_->any_hit_batch);
  connect(*links.any_hit_done, simt_->any_hit_done, rt.any_hit_done);
  if (!rt.fetches_nodes()) {
    connect(*links.node_fetch, rt.node_fetch, simt_->node_fetch);
    connect(*links.node_fetch_done, simt_->node_fetch_done, rt.node_fetch_done);
  }
  for (const modules::RtUnitModule::L1Port& port : rt.l1_ports()) {
    const auto found = std::find(clients.begin(), clients.end(), numbered(port.client, u));
    const auto i = static_cast<std::size_t>(found - clients.begin());
    if (!node_ports_.empty() && &port.request == &rt.node_request) {
      bind_node_port(u, port, i);
    } else {
      port.request.bind(*requests_.at(i));
      port.response.bind(*responses_.at(i));
    }
  }
  if (at_once_) rt.node_reads.bind(*l1_);
}

void Sm::bind_node_port(unsigned u, const modules::RtUnitModule::L1Port& port, std::size_t client) {
  const Link<MemoryRequest>& at_l1 = *requests_.at(client);
  const auto name_of = [&](const char* link) { return numbered(link, u); };
  node_requests_.push_back(link<MemoryRequest>(name_of("node_port_request"), at_l1.latency(), at_l1.capacity()));
  node_responses_.push_back(link<MemoryResponse>(name_of("node_port_response"), at_l1.latency(), at_l1.capacity()));
  modules::NodePortModule& unit = *node_ports_[u];
  connect(*node_requests_.back(), port.request, unit.request);
  connect(*node_responses_.back(), unit.response, port.response);
  unit.to_l1.bind(*requests_.at(client));
  unit.from_l1.bind(*responses_.at(client));
}

modules::L1Counters Sm::l1_counters() const {
  modules::L1Counters counters = l1_->counters();
  for (const auto& unit : node_ports_) unit->count(counters.own);
  return counters;
}

bool Sm::idle() const {
  bool idle = simt_->idle() && l1_->idle();
  for (const auto& rt : rt_) idle = idle && rt->idle();
  for (const auto& unit : node_ports_) idle = idle && unit->idle();
  for_each_link([&](const auto& link) { idle = idle && link.empty(); });
  return idle;
}

std::uint64_t Sm::progress() const {
  std::uint64_t sum = 0;
  const auto phases = simt_->counters().phases;
  sum += std::accumulate(phases.begin(), phases.end(), std::uint64_t{0});
  for (const auto& rt : rt_) sum += rt->progress();
  for (const auto& unit : node_ports_) sum += unit->progress();
  for_each_link([&](const auto& link) { sum += link.pushed(); });
  return sum;
}

std::vector<modules::Inventory> Sm::inventory() const {
  std::vector<modules::Inventory> parts;
  for (const auto& rt : rt_) {
    for (modules::Inventory& part : rt->inventory()) parts.push_back(std::move(part));
  }
  for (const auto& unit : node_ports_) parts.push_back(unit->inventory());
  parts.push_back(simt_->inventory());
  parts.push_back(l1_->inventory());
  modules::Inventory ports{std::string(name()) + ".l1_ports", {}, {}};
  for (const auto& [what, entries] :
       {std::pair("requests", modules::total_capacity(requests_) + modules::total_capacity(node_requests_)),
        std::pair("responses", modules::total_capacity(responses_) + modules::total_capacity(node_responses_))}) {
    ports.storage.push_back(
        {what, modules::StorageKind::flip_flop, entries * modules::kPacketBits, 1, 1, false, modules::kPacketBits});
  }
  parts.push_back(std::move(ports));
  return parts;
}

void Sm::dump_state(std::ostream& out) const {
  out << name() << '\n';
  for_each_link([&](const auto& link) { dump_link(out, link); });
  simt_->dump_state(out);
  for (const auto& rt : rt_) rt->dump_state(out);
  for (const auto& unit : node_ports_) unit->dump_state(out);
  l1_->dump_state(out);
}

}  // namespace grtx::sim
