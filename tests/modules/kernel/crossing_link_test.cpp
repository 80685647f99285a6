// A link whose ends run on two threads: what each end sees is what it sees of a link on one thread.
#include "grtx/modules/kernel/crossing_link.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <thread>
#include <vector>

#include "grtx/modules/kernel/link.h"

namespace grtx::modules {
namespace {

constexpr Cycle kCycles = 20'000;

/// Cycles of what was sent and taken.
struct Seen {
  std::vector<Cycle> sent, taken;
  std::vector<int> items;
  bool operator==(const Seen&) const = default;
};

/// Coins of one end: 1 in 3 cycles busy at times, nearly always at others.
class Coins {
 public:
  explicit Coins(unsigned seed) : random_(seed) {}
  bool next(Cycle now) { return random_() % 6 < ((now / 512) % 2 == 0 ? 5U : 2U); }

 private:
  std::mt19937 random_;
};

template <typename L>
void produce(L& link, Cycle now, Coins& coins, Seen& seen) {
  if (!coins.next(now) || !link.can_push(now)) return;
  link.push(now, static_cast<int>(seen.sent.size()));
  seen.sent.push_back(now);
}
template <typename L>
void consume(L& link, Cycle now, Coins& coins, Seen& seen) {
  const int* item = link.front(now);
  if (!coins.next(now + 256) || item == nullptr) return;
  seen.items.push_back(*item);
  seen.taken.push_back(now);
  link.pop(now);
}

class CrossingLinkTest : public ::testing::TestWithParam<std::pair<unsigned, std::size_t>> {};

TEST_P(CrossingLinkTest, BothEndsSeeWhatTheySeeOnOneThread) {
  const auto [latency, capacity] = GetParam();
  Seen alone;
  {
    Link<int> link("link", latency, capacity);
    Coins producer(1), consumer(2);
    for (Cycle now = 0; now < kCycles; ++now) {
      consume(link, now, consumer, alone);
      produce(link, now, producer, alone);
    }
  }
  ASSERT_GT(alone.items.size(), kCycles / 10);
  ThreadProgress producer_progress, consumer_progress;
  CrossingLink<int> link(latency, capacity, consumer_progress);
  Seen sent, taken;
  std::thread producer([&] {
    Coins coins(1);
    for (Cycle now = 0; now < kCycles; ++now) {
      produce(link, now, coins, sent);
      producer_progress.publish(now + 1);
    }
  });
  Coins coins(2);
  for (Cycle now = 0; now < kCycles; ++now) {
    if (now >= latency) producer_progress.wait_for(now - latency + 1);
    link.collect();
    consume(link, now, coins, taken);
    consumer_progress.publish(now + 1);
  }
  producer.join();
  EXPECT_EQ(sent.sent, alone.sent);
  EXPECT_EQ(taken.taken, alone.taken);
  EXPECT_EQ(taken.items, alone.items);
  EXPECT_EQ(link.size(), sent.sent.size() - taken.items.size());
}

INSTANTIATE_TEST_SUITE_P(LatencyAndCapacity, CrossingLinkTest,
                         ::testing::Values(std::pair(1U, std::size_t{1}), std::pair(1U, std::size_t{4}),
                                           std::pair(4U, std::size_t{1}), std::pair(4U, std::size_t{8}),
                                           std::pair(20U, std::size_t{32})));

TEST(CrossingLinkTest, WaitingForAThreadThatHasEndedThrows) {
  ThreadProgress consumer;
  CrossingLink<int> link(1, 1, consumer);
  link.push(0, 1);
  consumer.stop();
  EXPECT_THROW(link.can_push(5), ThreadStopped);
}

TEST(CrossingLinkTest, ItemsMayBeSentAheadOfTheirCycle) {
  ThreadProgress consumer;
  CrossingLink<int> link(2, 1, consumer, 4);
  ASSERT_TRUE(link.takes_ahead());
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(link.can_push(static_cast<Cycle>(10 + i)));
    link.push(static_cast<Cycle>(10 + i), i);
  }
  EXPECT_EQ(link.front(100), nullptr) << "not collected yet";
  link.collect();
  for (int i = 0; i < 4; ++i) {
    const auto visible = static_cast<Cycle>(12 + i);
    EXPECT_EQ(link.next_visible(), visible);
    EXPECT_EQ(link.front(visible - 1), nullptr);
    ASSERT_NE(link.front(visible), nullptr);
    EXPECT_EQ(*link.front(visible), i);
    link.pop(visible);
  }
  EXPECT_TRUE(link.empty());
}

}  // namespace
}  // namespace grtx::modules
