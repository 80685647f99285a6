// SPDX-License-Identifier: Apache-2.0
// L1: a port as wide as it is told takes and answers that many sectors per cycle, a bank still one; refused reads may
// wait aside, so that hits behind them go on.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/// Reads sectors of the L1 in given cycles.
class Asker final : public ClockedModule {
 public:
  Asker(const sc_core::sc_module_name& name, ClockDomain& clock) : ClockedModule(name, clock) {}
  void ask(Cycle cycle, std::uint64_t address) {
    script_.emplace_back(cycle, address);
    alarm_.request(script_.front().first);
  }
  sc_core::sc_port<read_at_once_if> l1{"l1"};
  std::vector<ReadAtOnce> answers;

 private:
  Cycle tick(Cycle now) override {
    while (next_ < script_.size() && script_[next_].first <= now) {
      MemoryRequest sector;
      sector.address = script_[next_].second;
      sector.tag = static_cast<std::uint32_t>(next_++);
      answers.push_back(l1->read_at_once(now, sector));
    }
    return next_ < script_.size() ? script_[next_].first : kNever;
  }
  std::vector<std::pair<Cycle, std::uint64_t>> script_;
  std::size_t next_ = 0;
};

struct AtOnceBench {
  explicit AtOnceBench(const L1Cache::Config& config, bool asker_first = false) {
    if (asker_first) asker.emplace("asker", clock);
    l1.emplace("l1", config, clock);
    if (!asker_first) asker.emplace("asker", clock);
    asker->l1.bind(*l1);
    for (unsigned i = 0; i < config.clients; ++i) {
      links.push_back(std::make_unique<PortLinks>("client" + std::to_string(i)));
      l1->request[i].bind(links[i]->request);
      l1->response[i].bind(links[i]->response);
      clients.push_back(std::make_unique<MockClient>("client" + std::to_string(i), clock, *links[i]));
    }
    l1->to_memory.bind(down.request);
    l1->from_memory.bind(down.response);
  }
  ClockDomain clock{"clock", 1365.0};
  PortLinks down{"down"};
  MockMemory memory{"memory", clock, down.request, down.response, L1Bench::kMemoryLatency};
  std::optional<Asker> asker;
  std::optional<L1Cache> l1;
  std::vector<std::unique_ptr<PortLinks>> links;
  std::vector<std::unique_ptr<MockClient>> clients;
};

/// Asked without a link, the L1 answers in the same cycle and behind its own work of that cycle, whichever of the two
/// modules is called first.
class L1ReadAtOnce : public SystemCTest {};

// Asked in 10, the miss leaves in 11, is at the memory in 12 and filled in 112; the port has the answer in 113.
TEST_F(L1ReadAtOnce, AMissIsAnsweredThroughThePortAndASectorIsThereInTheCycleOfItsFill) {
  for (const bool asker_first : {false, true}) {
    fresh_context();
    AtOnceBench bench({}, asker_first);
    bench.asker->ask(10, 0x1000);
    bench.asker->ask(111, 0x1000);
    bench.asker->ask(112, 0x1000);
    bench.asker->ask(500, 0x1000);
    EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
    EXPECT_EQ(bench.asker->answers,
              (std::vector{ReadAtOnce::under_way, ReadAtOnce::under_way, ReadAtOnce::hit, ReadAtOnce::hit}))
        << asker_first;
    ASSERT_EQ(bench.memory.arrivals().size(), 1u);
    EXPECT_EQ(bench.memory.arrivals()[0].cycle, 12u);
    ASSERT_EQ(bench.clients[0]->answers().size(), 2u);
    EXPECT_EQ(bench.clients[0]->answers()[0].cycle, 113u);
    EXPECT_EQ(bench.clients[0]->answers()[1].cycle, 114u) << "the merged read; one answer a cycle";
    const RegionCounters tlas = bench.l1->counters().region[0];
    EXPECT_EQ(tlas.reads, 4u);
    EXPECT_EQ(tlas.misses, 1u);
    EXPECT_EQ(tlas.hits_on_miss, 1u);
    EXPECT_EQ(tlas.hits, 2u);
    EXPECT_EQ(bench.l1->counters().responses, 4u);
    EXPECT_TRUE(bench.l1->idle());
  }
}

TEST_F(L1ReadAtOnce, AMissWithoutAPlaceIsRefusedAndAskedAgain) {
  L1Cache::Config config;
  config.mshr_entries = 1;
  config.mshr_merges = 2;
  AtOnceBench bench(config);
  for (const Cycle cycle : {10u, 11u, 12u}) bench.asker->ask(cycle, 0x1000);
  bench.asker->ask(13, 0x2000);
  bench.asker->ask(112, 0x2000);  // the first miss is filled in this cycle
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(bench.asker->answers, (std::vector{ReadAtOnce::under_way, ReadAtOnce::under_way, ReadAtOnce::refused,
                                               ReadAtOnce::refused, ReadAtOnce::under_way}));
  EXPECT_EQ(bench.l1->counters().stalls[static_cast<std::size_t>(L1Stall::merges_full)], 1u);
  EXPECT_EQ(bench.l1->counters().stalls[static_cast<std::size_t>(L1Stall::mshr_full)], 1u);
  EXPECT_EQ(bench.l1->counters().accesses(), 3u);
}

TEST_F(L1ReadAtOnce, ItTakesNoBankFromOthers) {
  L1Cache::Config config;
  config.banks = 1;
  config.latency = 20;
  AtOnceBench bench(config);
  bench.asker->ask(10, 0x1000);
  bench.asker->ask(500, 0x1000);
  const auto beside = bench.clients[1]->read(500, 0x1000);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(bench.asker->answers.back(), ReadAtOnce::hit);
  EXPECT_EQ(bench.clients[1]->answered(beside), 520u);
  EXPECT_EQ(bench.l1->counters().stalls[static_cast<std::size_t>(L1Stall::bank_conflict)], 0u);
}

}  // namespace
}  // namespace grtx::modules
