// A ray's log: what is forwarded is named by runs or copied, and every round reads what the round before left to it.
#include "grtx/modules/rt_unit/decide/checkpoint_log.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace grtx::modules {
namespace {

/// The memory behind a log, with the numbers of entries in its places.
class Ray {
 public:
  Ray(std::uint64_t capacity, bool lifo) : capacity_(capacity), lifo_(lifo), ring_((4 * capacity + 7) / 8 * 8, kRun) {}

  void begin(bool first, bool replays) {
    log.begin(first, replays, capacity_, lifo_);
    source_ = replays ? written_ : std::vector<int>{};
    if (lifo_) std::reverse(source_.begin(), source_.end());
    written_.clear();
    next_ = 0;
  }
  bool has_more() const { return next_ < source_.size(); }
  /// Reads the next entry and looks into memory whether it is the one that was to come.
  void read() {
    CheckpointLog::Read item = log.read();
    if (item.run) {
      EXPECT_EQ(ring_[item.position % ring_.size()], kRun);
      item = log.read();
    }
    EXPECT_FALSE(item.run);
    last_ = source_[next_++];
    EXPECT_EQ(ring_[item.position % ring_.size()], last_) << "place " << item.position;
  }
  void forward() {
    written_.push_back(last_);
    unsigned items = log.submit(1, true, false);
    if (items > 0) items -= close();
    if (items > 0) {
      put(last_);
    } else {
      run_.push_back(last_);
    }
  }
  void write(unsigned entries) {
    unsigned items = log.submit(entries, false, false);
    items -= close();
    EXPECT_EQ(items, entries);
    for (; items > 0; --items) {
      written_.push_back(++entries_);
      put(entries_);
    }
  }
  void end() {
    const unsigned items = log.submit(0, false, true);
    EXPECT_EQ(items, close());
  }
  std::size_t written() const { return written_.size(); }
  CheckpointLog::Counters counters() const {
    CheckpointLog::Counters all;
    log.count(all);
    return all;
  }
  CheckpointLog log;

 private:
  static constexpr int kRun = -1;
  unsigned close() {
    if (run_.empty()) return 0;
    if (run_.size() > 1) {
      const CheckpointLog::Appended item = log.append();
      EXPECT_TRUE(item.run);
      ring_[item.position % ring_.size()] = kRun;
    } else {
      put(run_[0]);
    }
    run_.clear();
    return 1;
  }
  void put(int entry) {
    const CheckpointLog::Appended item = log.append();
    EXPECT_FALSE(item.run);
    ring_[item.position % ring_.size()] = entry;
  }

  std::uint64_t capacity_;
  bool lifo_;
  std::vector<int> ring_;
  std::vector<int> source_, written_;
  std::vector<int> run_;
  std::size_t next_ = 0;
  int last_ = 0, entries_ = 0;
};

void write_round(Ray& ray, unsigned entries) {
  ray.begin(true, false);
  ray.write(entries);
  ray.end();
}

TEST(CheckpointLog, ForwardedNeighboursBecomeOneRunEntry) {
  Ray ray(64, false);
  write_round(ray, 6);
  ray.begin(false, true);
  for (unsigned i = 0; i < 6; ++i) {
    ray.read();
    if (i != 3) ray.forward();  // 0, 1, 2 and 4, 5
  }
  ray.end();
  EXPECT_EQ(ray.log.appended(), 6u + 2u);
  ray.begin(false, true);
  for (unsigned i = 0; i < 5; ++i) ray.read();
  const CheckpointLog::Counters c = ray.counters();
  EXPECT_EQ(c.runs_written, 2u);
  EXPECT_EQ(c.runs_read, 2u);
  EXPECT_EQ(c.entries_referenced, 5u);
  EXPECT_EQ(c.references_read, 5u);
  EXPECT_EQ(c.copies_forced, 0u);
}

TEST(CheckpointLog, OneThatIsForwardedAloneIsCopied) {
  Ray ray(64, false);
  write_round(ray, 3);
  ray.begin(false, true);
  for (unsigned i = 0; i < 3; ++i) {
    ray.read();
    if (i != 1) ray.forward();
  }
  ray.end();
  EXPECT_EQ(ray.log.appended(), 3u + 2u);
  EXPECT_EQ(ray.counters().runs_written, 0u);
}

TEST(CheckpointLog, ANewEntryEndsTheRun) {
  Ray ray(64, false);
  write_round(ray, 4);
  ray.begin(false, true);
  for (unsigned i = 0; i < 4; ++i) {
    ray.read();
    ray.forward();
    if (i == 1) ray.write(1);
  }
  ray.end();
  EXPECT_EQ(ray.counters().runs_written, 2u);
  ray.begin(false, true);
  while (ray.has_more()) ray.read();
}

TEST(CheckpointLog, WhatIsOlderThanABufferIsCopied) {
  // Entries 0 and 1 are forwarded again and again while others come and go: after four places more they are copied.
  Ray ray(4, false);
  write_round(ray, 2);
  for (unsigned round = 0; round < 8; ++round) {
    ray.begin(false, true);
    for (unsigned i = 0; i < 2; ++i) {
      ray.read();
      ray.forward();
    }
    while (ray.has_more()) ray.read();
    ray.write(1);
    ray.end();
  }
  EXPECT_GT(ray.counters().copies_forced, 0u);
  EXPECT_GT(ray.counters().runs_written, 0u);
}

TEST(CheckpointLog, RunsThatNobodyReadsAreLeft) {
  Ray ray(64, false);
  write_round(ray, 4);
  ray.begin(false, true);
  for (unsigned i = 0; i < 4; ++i) {
    ray.read();
    ray.forward();
  }
  ray.end();
  EXPECT_EQ(ray.counters().runs_left, 1u) << "written last";
  ray.begin(true, false);  // of another ray
  EXPECT_EQ(ray.counters().runs_left, 1u);
  EXPECT_EQ(ray.counters().references_left, 4u);
}

// Each round reads what the round before wrote, in its order, whatever was named, copied or overwritten meanwhile.
TEST(CheckpointLog, NothingIsOverwrittenBeforeItIsRead) {
  for (const bool lifo : {false, true}) {
    for (const std::uint64_t capacity : {1u, 2u, 5u, 16u, 64u}) {
      for (unsigned seed = 0; seed < 20 && !::testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(fmt::format("{} capacity {} seed {}", lifo ? "lifo" : "fifo", capacity, seed));
        std::mt19937 random(seed);
        const auto one_in = [&](unsigned n) { return random() % n == 0; };
        Ray ray(capacity, lifo);
        const unsigned leaves = 1 + seed % 6;  // one in so many source entries is taken
        for (unsigned round = 0; round < 60; ++round) {
          const bool first = round == 0 || one_in(17);
          ray.begin(first, !first && !one_in(13));
          const auto room = [&] { return static_cast<unsigned>(capacity - ray.written()); };
          do {
            const bool more = ray.has_more();
            if (more) ray.read();
            if (more && !one_in(leaves) && room() > 0) {
              ray.forward();
            } else if (room() > 0 && one_in(2)) {
              ray.write(1 + static_cast<unsigned>(random()) % std::min(room(), 6u));
            }
          } while (ray.has_more());
          ray.end();
        }
        const CheckpointLog::Counters c = ray.counters();
        EXPECT_EQ(c.runs_written, c.runs_read + c.runs_left);
        EXPECT_EQ(c.entries_referenced, c.references_read + c.references_left);
      }
    }
  }
}

}  // namespace
}  // namespace grtx::modules
