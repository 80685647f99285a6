// SPDX-License-Identifier: Apache-2.0
// Processor time of a request of the L1 alone: one client, one read a cycle, a memory of 100 cycles below it. The same
// requests go to the L1 of another simulator (bench/peers.py).
//
//   bench/l1_requests KILOBYTES REQUESTS    reads of random 64 B blocks of so many KB; the L1 has 64 KB
#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <deque>
#include <systemc>
#include <utility>

#include "bench/processor_time.h"
#include "grtx/base/split_mix.h"
#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/messages/memory_request.h"

namespace {

using namespace grtx::modules;
using grtx::Cycle;
using grtx::SplitMix64;

/// Sends a read a cycle where the L1 takes it, and takes one response a cycle.
class Client final : public ClockedModule {
 public:
  Client(const sc_core::sc_module_name& name, ClockDomain& clock, std::uint64_t blocks, std::uint64_t requests)
      : ClockedModule(name, clock),
        request("request", 1, 8),
        response("response", 1, 8),
        blocks_(blocks),
        left_(requests) {
    response.wake(&alarm_);
    alarm_.request(1);
  }

  Link<MemoryRequest> request;
  Link<MemoryResponse> response;
  std::uint64_t answered = 0;
  Cycle last = 0;

 private:
  Cycle tick(Cycle now) override {
    if (response.front(now) != nullptr) {
      response.pop(now);
      ++answered;
      last = now;
    }
    if (left_ > 0 && request.can_push(now)) {
      request.push(now, {.address = numbers_.below(blocks_) * 64, .tag = static_cast<std::uint32_t>(left_)});
      --left_;
    }
    return left_ > 0 || response.size() > 0 ? now + 1 : kNever;
  }

  std::uint64_t blocks_;
  std::uint64_t left_;
  SplitMix64 numbers_{1};
};

/// Takes a request a cycle and answers each 100 cycles later.
class Memory final : public ClockedModule {
 public:
  Memory(const sc_core::sc_module_name& name, ClockDomain& clock)
      : ClockedModule(name, clock), request("request", 1, 8), response("response", 1, 8) {
    request.wake(&alarm_);
  }

  Link<MemoryRequest> request;
  Link<MemoryResponse> response;

 private:
  Cycle tick(Cycle now) override {
    if (const MemoryRequest* arrived = request.front(now); arrived != nullptr) {
      pending_.emplace_back(now + 99, response_to(*arrived));
      request.pop(now);
    }
    if (!pending_.empty() && pending_.front().first <= now && response.can_push(now)) {
      response.push(now, pending_.front().second);
      pending_.pop_front();
    }
    if (request.size() > 0) return now + 1;
    return pending_.empty() ? kNever : std::max(now + 1, pending_.front().first);
  }

  std::deque<std::pair<Cycle, MemoryResponse>> pending_;
};

}  // namespace

int sc_main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "l1_requests: must be given KILOBYTES and REQUESTS\n");
    return 2;
  }
  const std::uint64_t blocks = std::strtoull(argv[1], nullptr, 10) * 16, requests = std::strtoull(argv[2], nullptr, 10);
  if (blocks == 0 || requests == 0) {
    fmt::print(stderr, "l1_requests: KILOBYTES and REQUESTS must be above 0\n");
    return 2;
  }
  set_time_resolution_to_fs();
  ClockDomain clock("clock", 1365.0);
  Client client("client", clock, blocks, requests);
  Memory memory("memory", clock);
  L1CacheConfig config;
  config.clients = 1;
  config.geometry.bytes = 64 * 1024;
  config.geometry.line_bytes = 64;
  config.geometry.ways = 16;
  config.latency = 5;
  const auto l1 = make_l1_cache("l1", config, clock);
  l1->request[0].bind(client.request);
  l1->response[0].bind(client.response);
  l1->to_memory.bind(memory.request);
  l1->from_memory.bind(memory.response);
  sc_core::sc_start(sc_core::SC_ZERO_TIME);
  const double began = grtx::bench::cpu_seconds();
  while (client.answered < requests && sc_core::sc_pending_activity())
    sc_core::sc_start(sc_core::sc_time(10, sc_core::SC_US));
  const double seconds = grtx::bench::cpu_seconds() - began;
  if (client.answered != requests) {
    fmt::print(stderr, "l1_requests: {} of {} reads were answered\n", client.answered, requests);
    return 1;
  }
  fmt::print("{} {} {} {:.1f}\n", requests, l1->counters().fills, client.last,
             1e9 * seconds / static_cast<double>(requests));
  return 0;
}
