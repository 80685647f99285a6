// SPDX-License-Identifier: Apache-2.0
// An L1 cache between mock clients and a mock memory of fixed latency.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {

struct L1Bench {
  static constexpr Cycle kMemoryLatency = 100;  ///< from request visible at the memory to response visible at the L1

  explicit L1Bench(L1Cache::Config config = {}, Cycle memory_latency = kMemoryLatency, bool idle_skip = true)
      : clock("clock", 1365.0, idle_skip),
        down("down"),
        memory("memory", clock, down.request, down.response, memory_latency),
        l1("l1", config, clock) {
    for (unsigned i = 0; i < config.clients; ++i) {
      links.push_back(std::make_unique<PortLinks>("client" + std::to_string(i)));
      l1.request[i].bind(links[i]->request);
      l1.response[i].bind(links[i]->response);
      clients.push_back(std::make_unique<MockClient>("client" + std::to_string(i), clock, *links[i]));
    }
    l1.to_memory.bind(down.request);
    l1.from_memory.bind(down.response);
  }
  MockClient& client(std::size_t i = 0) { return *clients[i]; }

  /// Every request was answered once and the cache is empty.
  bool conserved() const {
    bool all = l1.idle();
    std::uint64_t sent = 0;
    for (const auto& c : clients) {
      all = all && c->complete();
      sent += c->sent();
    }
    return all && l1.counters().accesses() == sent && l1.counters().responses == sent;
  }

  ClockDomain clock;
  PortLinks down;
  MockMemory memory;
  L1Cache l1;
  std::vector<std::unique_ptr<PortLinks>> links;
  std::vector<std::unique_ptr<MockClient>> clients;
};

/// A miss: tag latency, the link to the memory, the memory, and the response link.
inline Cycle l1_miss_latency(const L1Cache::Config& config, Cycle memory_latency) {
  return config.tag_latency + 1 + memory_latency + 1;
}

}  // namespace grtx::modules
