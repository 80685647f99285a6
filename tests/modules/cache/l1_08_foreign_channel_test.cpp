// SPDX-License-Identifier: Apache-2.0
// The L1 between channels that are not the project's own: every cycle is that of the same run over our Links.
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "modules/foreign_channel.h"
#include "modules/memory_mocks.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

/// The links around an L1 of two clients, of either kind.
template <template <typename> class Channel>
struct Channels;
template <>
struct Channels<Link> {
  template <typename T>
  static std::unique_ptr<Link<T>> make(unsigned latency, std::size_t capacity) {
    return std::make_unique<Link<T>>("link", latency, capacity);
  }
};
template <>
struct Channels<ForeignChannel> {
  template <typename T>
  static std::unique_ptr<ForeignChannel<T>> make(unsigned latency, std::size_t capacity) {
    return std::make_unique<ForeignChannel<T>>(latency, capacity);
  }
};

using Answers = std::vector<std::pair<Cycle, std::uint32_t>>;

/// Two clients send 400 requests each, as fast as they are taken; a memory answers after 50 cycles.
template <template <typename> class Channel>
std::pair<Answers, std::uint64_t> run_l1() {
  ClockDomain clock("clock", 1365.0);
  L1Cache::Config config;
  config.clients = 2;
  config.mshr_entries = 8;  // so that requests wait
  L1Cache l1("l1", config, clock);
  const auto down = Channels<Channel>::template make<MemoryRequest>(1, 2);
  const auto up = Channels<Channel>::template make<MemoryResponse>(1, 4);
  l1.to_memory.bind(*down);
  l1.from_memory.bind(*up);
  std::vector<decltype(Channels<Channel>::template make<MemoryRequest>(1, 1))> requests;
  std::vector<decltype(Channels<Channel>::template make<MemoryResponse>(1, 1))> responses;
  for (unsigned c = 0; c < 2; ++c) {
    requests.push_back(Channels<Channel>::template make<MemoryRequest>(1, 3));
    responses.push_back(Channels<Channel>::template make<MemoryResponse>(1, 3));
    l1.request[c].bind(*requests[c]);
    l1.response[c].bind(*responses[c]);
  }
  Answers answers;
  std::uint32_t sent[2] = {};
  std::deque<std::pair<Cycle, MemoryResponse>> memory;
  TickProcess world("world", clock, [&](Cycle now) {
    for (unsigned c = 0; c < 2; ++c) {
      if (const MemoryResponse* r = responses[c]->front(now); r != nullptr && now % 3 != c) {
        answers.emplace_back(now, r->tag);
        responses[c]->pop(now);
      }
      if (sent[c] < 400 && requests[c]->can_push(now)) {
        Random random(sent[c] * 2 + c);
        MemoryRequest request;
        request.address = random.below(600) * kSectorBytes;
        request.tag = sent[c] * 2 + c;
        request.write = random.chance(20);
        request.region = Region::tlas;
        requests[c]->push(now, request);
        ++sent[c];
      }
    }
    if (const MemoryRequest* r = down->front(now)) {
      memory.push_back({now + 50, {r->address, r->tag, r->client, r->sm, r->region, r->write, r->prefetch}});
      down->pop(now);
    }
    if (!memory.empty() && memory.front().first <= now && up->can_push(now)) {
      up->push(now, memory.front().second);
      memory.pop_front();
    }
    if (answers.size() < 800) clock.request(now + 1);
  });
  clock.request(0);
  sc_core::sc_start(sc_core::sc_time::from_value(100'000 * clock.period_fs()));
  EXPECT_TRUE(l1.idle());
  return {answers, l1.counters().sent_reads};
}

class L1ForeignChannel : public SystemCTest {};

TEST_F(L1ForeignChannel, IsAsFastAsAcrossOurLinks) {
  const auto own = run_l1<Link>();
  fresh_context();
  const auto foreign = run_l1<ForeignChannel>();
  EXPECT_EQ(own.first.size(), 800U);
  EXPECT_EQ(foreign, own);
  EXPECT_GT(own.second, 0U);
}

}  // namespace
}  // namespace grtx::modules
