// SPDX-License-Identifier: Apache-2.0
// L1: a port as wide as it is told takes and answers that many sectors per cycle, a bank still one; refused reads may
// wait aside, so that hits behind them go on.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

/// Pushes all its requests in one cycle and notes when each answer came, many a cycle.
class Burst {
 public:
  Burst(L1Bench& bench, unsigned client = 0)
      : links_(*bench.links[client]), process_("burst", bench.clock, [this](Cycle now) { tick(now); }) {
    process_.watch(links_.response);
  }
  void at(ClockDomain& clock, Cycle cycle, std::vector<MemoryRequest> requests) {
    cycle_ = cycle;
    requests_ = std::move(requests);
    clock.request(cycle);
  }
  std::vector<std::pair<std::uint32_t, Cycle>> answers;

 private:
  void tick(Cycle now) {
    if (now == cycle_) {
      for (const MemoryRequest& r : requests_) links_.request.push(now, r);
    }
    while (const MemoryResponse* r = links_.response.front(now)) {
      answers.emplace_back(r->tag, now);
      links_.response.pop(now);
    }
  }
  PortLinks& links_;
  Cycle cycle_ = 0;
  std::vector<MemoryRequest> requests_;
  TickProcess process_;
};

class L1Ports : public SystemCTest {
 protected:
  static std::vector<MemoryRequest> sectors(unsigned count, unsigned stride = 1) {
    std::vector<MemoryRequest> all;
    for (unsigned i = 0; i < count; ++i) all.push_back({.address = std::uint64_t{i} * stride * kSectorBytes, .tag = i});
    return all;
  }
};

TEST_F(L1Ports, AWidePortAnswersSoManyHitsACycle) {
  for (const unsigned width : {1u, 2u, 4u}) {
    fresh_context();
    L1Cache::Config config;
    config.clients = 1;
    config.widths = {width};
    config.perfect = true;
    L1Bench bench(config);
    Burst burst(bench);
    burst.at(bench.clock, 10, sectors(8));
    EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
    ASSERT_EQ(burst.answers.size(), 8u);
    for (unsigned i = 0; i < 8; ++i) {
      EXPECT_EQ(burst.answers[i].first, i);
      EXPECT_EQ(burst.answers[i].second, 11 + config.latency + i / width) << "width " << width;
    }
  }
}

TEST_F(L1Ports, ABankServesOneSectorACycleHoweverWideThePort) {
  L1Cache::Config config;
  config.clients = 1;
  config.widths = {4};
  config.perfect = true;
  L1Bench bench(config);
  Burst burst(bench);
  burst.at(bench.clock, 10, sectors(8, config.banks));  // all in bank 0
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  ASSERT_EQ(burst.answers.size(), 8u);
  for (unsigned i = 0; i < 8; ++i) EXPECT_EQ(burst.answers[i].second, 11 + config.latency + i);
}

}  // namespace
}  // namespace grtx::modules
