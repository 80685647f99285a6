// Counts of a trace: what the trace gives, stack distances against a list that is searched, and the file beside it.
#include "grtx/rtl_tlm/estimate/model/trace_counts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <list>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/model/model_work.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using traces::EventKind;

traces::testing::RandomTrace trace_of(std::uint32_t seed) {
  traces::testing::RandomOptions random;
  random.seed = seed;
  random.groups = 6;
  random.warp_size = 32;
  random.checkpoint = true;
  random.capacity = 1000;
  return traces::testing::random_trace(random);
}

/// Classes of a group's visits, lanes in step, by a plain least-recently-used list.
std::vector<std::array<std::uint32_t, kReuseClasses>> plain_reuse(const traces::RayGroup& group) {
  std::size_t rounds = 0;
  for (const traces::Ray& ray : group.rays) rounds = std::max(rounds, ray.rounds.size());
  std::vector<std::array<std::uint32_t, kReuseClasses>> reuse(rounds);
  std::list<std::uint32_t> recent;
  std::vector<std::size_t> begin(group.rays.size());
  for (std::size_t r = 0; r < rounds; ++r) {
    std::vector<std::vector<std::uint32_t>> units(group.rays.size());
    std::size_t longest = 0;
    for (std::size_t i = 0; i < group.rays.size(); ++i) {
      const traces::Ray& ray = group.rays[i];
      if (r >= ray.rounds.size()) continue;
      for (std::size_t e = begin[i]; e < begin[i] + ray.rounds[r].event_count; ++e) {
        const traces::Event& event = ray.events[e];
        if (event.kind() == EventKind::visit_internal) units[i].push_back(group.nodes[event.node].address);
        if (event.kind() == EventKind::visit_instance || event.kind() == EventKind::visit_leaf) {
          units[i].push_back(event.node);
        }
      }
      begin[i] += ray.rounds[r].event_count;
      longest = std::max(longest, units[i].size());
    }
    for (std::size_t step = 0; step < longest; ++step) {
      for (const auto& lane : units) {
        if (step >= lane.size()) continue;
        const auto found = std::find(recent.begin(), recent.end(), lane[step]);
        std::size_t reuse_class = kReuseClasses - 1;
        if (found != recent.end()) {
          const auto distance = static_cast<std::uint32_t>(std::distance(recent.begin(), found));
          reuse_class = std::min<std::size_t>(std::bit_width(distance), kReuseClasses - 2);
          recent.erase(found);
        }
        recent.push_front(lane[step]);
        ++reuse[r][reuse_class];
      }
    }
  }
  return reuse;
}

TEST(TraceCounts, AreWhatTheTraceGives) {
  for (const std::uint32_t seed : {3U, 17U, 90U}) {
    const auto trace = trace_of(seed);
    std::uint64_t visits = 0, any_hits = 0, written = 0, read = 0, expected_visits = 0, expected_any_hits = 0,
                  expected_written = 0, expected_read = 0;
    for (const traces::RayGroup& group : trace.groups) {
      for (const traces::Ray& ray : group.rays) {
        for (const traces::Event& event : ray.events) {
          const EventKind kind = event.kind();
          expected_visits += kind <= EventKind::visit_leaf;
          expected_any_hits += kind == EventKind::visit_leaf && traces::calls_any_hit(event.outcome());
          expected_written += static_cast<unsigned>(std::popcount(event.checkpoints));
          expected_read += kind == EventKind::replay_take || kind == EventKind::replay_forward;
        }
      }
      const GroupCounts counts = count_group(group);
      const auto reuse = plain_reuse(group);
      ASSERT_EQ(counts.rounds.size(), reuse.size());
      for (std::size_t r = 0; r < reuse.size(); ++r) {
        EXPECT_EQ(counts.rounds[r].reuse, reuse[r]) << "seed " << seed << ", group " << group.index << ", round " << r;
        written += counts.rounds[r].written;
        read += counts.rounds[r].read;
        for (const LaneCounts& lane : counts.rounds[r].lanes) {
          visits += lane.visits;
          any_hits += lane.any_hits;
        }
      }
    }
    EXPECT_GT(visits, 0U);
    EXPECT_EQ(visits, expected_visits);
    EXPECT_EQ(any_hits, expected_any_hits);
    EXPECT_EQ(written, expected_written);
    EXPECT_EQ(read, expected_read);
  }
}

TEST(TraceCounts, HitsGrowWithTheCacheFromNoneToAllThatComeAgain) {
  RoundCounts round;
  round.reuse[0] = 10;                  // distance 0
  round.reuse[3] = 20;                  // 4 to 7
  round.reuse[kReuseClasses - 1] = 10;  // never before
  EXPECT_EQ(hits_within(round, 0.0), 0.0);
  EXPECT_EQ(hits_within(round, 1.0), 0.25);
  EXPECT_EQ(hits_within(round, 4.0), 0.25) << "four nodes hold distances 0 to 3";
  EXPECT_EQ(hits_within(round, 4.0 * std::sqrt(2.0)), 0.5);
  EXPECT_EQ(hits_within(round, 8.0), 0.75);
  EXPECT_EQ(hits_within(round, 1e9), 0.75);
  EXPECT_EQ(hits_within(RoundCounts{}, 8.0), 0.0);
}

class CountsFile : public ::testing::Test {
 protected:
  CountsFile() {
    const auto trace = trace_of(5);
    traces::testing::write_trace(file_.path(), trace.header, trace.groups);
  }
  ~CountsFile() override { std::remove(counts_path(file_.path()).c_str()); }
  std::string counted() const {
    const traces::Reader reader(file_.path());
    std::string text;
    for (const GroupCounts& group : counts_of(reader).groups) {
      text += "g" + std::to_string(static_cast<int>(group.kind));
      for (const RoundCounts& round : group.rounds) {
        for (const std::uint32_t n : {round.units, round.written, round.read, round.processed}) {
          text += " " + std::to_string(n);
        }
        for (const std::uint32_t n : round.reuse) text += "," + std::to_string(n);
        for (const LaneCounts& lane : round.lanes) {
          text += " " + std::to_string(lane.visits) + "/" + std::to_string(lane.any_hits);
        }
      }
    }
    return text;
  }
  traces::testing::TemporaryFile file_{"counts.grtx"};
};

TEST_F(CountsFile, IsReadBackAsItWasCounted) {
  const std::string first = counted();
  const std::string bytes = read_file(counts_path(file_.path()));
  EXPECT_EQ(counted(), first);
  EXPECT_EQ(read_file(counts_path(file_.path())), bytes) << "was not written again";
}

TEST_F(CountsFile, IsMadeAgainWhenItIsDamagedCutOrOfAnotherTrace) {
  const std::string first = counted();
  const std::string path = counts_path(file_.path());
  const std::string bytes = read_file(path);
  for (std::size_t at = 14; at < bytes.size(); at += bytes.size() / 40) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_file(path, damaged);
    EXPECT_EQ(counted(), first) << "byte " << at;
    EXPECT_EQ(read_file(path), bytes) << "byte " << at;
    write_file(path, bytes.substr(0, at));
    EXPECT_EQ(counted(), first) << "cut at " << at;
  }
}

TEST_F(CountsFile, OfAnotherKindIsNotOverwritten) {
  const std::string path = counts_path(file_.path());
  write_file(path, "my notes\n");
  EXPECT_THROW(counted(), Error);
  EXPECT_EQ(read_file(path), "my notes\n");
}

}  // namespace
}  // namespace grtx::sim
