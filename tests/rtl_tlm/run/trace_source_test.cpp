// SPDX-License-Identifier: Apache-2.0
// The trace source: same groups with and without decoding ahead, bounded memory, chosen groups, errors that name the
// place.
#include "grtx/rtl_tlm/run/trace_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>

#include "grtx/base/error.h"
#include "grtx/traces/decoded_size.h"
#include "parameter_names.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using traces::testing::TemporaryFile;

traces::testing::RandomTrace random_trace(std::uint64_t groups) {
  traces::testing::RandomOptions options;
  options.seed = 21;
  options.groups = groups;
  options.warp_size = 16;
  return traces::testing::random_trace(options);
}

class TraceSourceAhead : public ::testing::TestWithParam<unsigned> {};

TEST_P(TraceSourceAhead, HandsOutEveryGroupInOrderAndReusesMemory) {
  const auto trace = random_trace(60);
  const TemporaryFile file;
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  const traces::Reader reader(file.path());
  TraceSource source(reader, GetParam());
  ASSERT_EQ(source.count(), 60u);
  constexpr std::size_t kResident = 5;
  std::deque<std::pair<std::uint64_t, const traces::RayGroup*>> held;
  for (std::uint64_t i = 0; i < source.count(); ++i) {
    if (held.size() == kResident) {
      const auto one = held.begin() + static_cast<std::ptrdiff_t>(i % kResident);  // not in order of acquisition
      EXPECT_EQ(*one->second, trace.groups[one->first]);                           // untouched while it was held
      source.release(one->first);
      held.erase(one);
    }
    held.emplace_back(i, source.acquire(i));
    EXPECT_EQ(*held.back().second, trace.groups[i]);
    EXPECT_EQ(source.groups_held(), held.size());
  }
  EXPECT_LE(source.groups_allocated(), kResident + GetParam() + 1);
}

TEST_P(TraceSourceAhead, HandsOutChosenGroups) {
  const auto trace = random_trace(10);
  const TemporaryFile file;
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  const traces::Reader reader(file.path());
  TraceSource source(reader, {7, 2, 9}, GetParam());
  ASSERT_EQ(source.count(), 3u);
  for (const auto& [position, index] : {std::pair{0u, 7u}, {1u, 2u}, {2u, 9u}}) {
    EXPECT_EQ(*source.acquire(position), trace.groups[index]);
  }
  EXPECT_THROW(TraceSource(reader, {3, 10}, GetParam()), Error);
}

TEST_P(TraceSourceAhead, CanBeDroppedBeforeTheEnd) {
  const auto trace = random_trace(40);
  const TemporaryFile file;
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  const traces::Reader reader(file.path());
  TraceSource source(reader, GetParam());
  EXPECT_EQ(*source.acquire(0), trace.groups[0]);
}

INSTANTIATE_TEST_SUITE_P(Depth, TraceSourceAhead, ::testing::Values(0u, 1u, 8u), grtx::test::PrintedName{});

TEST(TraceSource, LargeGroupsAreDecodedAheadUpToTheirBytes) {
  const test::TinyTrace tiny{24, 32};
  std::vector<traces::RayGroup> groups;
  for (unsigned i = 0; i < tiny.groups; ++i) {
    traces::RayGroup& group = groups.emplace_back(test::tiny_group(tiny, i));
    for (traces::Ray& ray : group.rays) {
      ray.rounds.front().k_count = ray.rounds.front().processed_count = 0;
      ray.processed.clear();
      ray.rounds.resize(5'000, ray.rounds.front());
      const std::vector<traces::Event> events = ray.events;
      while (ray.events.size() < 3 * ray.rounds.size())
        ray.events.insert(ray.events.end(), events.begin(), events.end());
    }
  }
  const TemporaryFile file;
  traces::testing::write_trace(file.path(), test::tiny_header(tiny), groups);
  const traces::Reader reader(file.path());
  TraceSource source(reader, kDecodeAhead);
  const std::size_t ahead = kDecodeAheadBytes / traces::decoded_bytes(groups.front()) + 1;
  ASSERT_LT(ahead, tiny.groups / 2);
  for (unsigned i = 0; i < tiny.groups; ++i) {
    EXPECT_EQ(*source.acquire(i), groups[i]);
    source.release(i);
  }
  EXPECT_LE(source.groups_allocated(), ahead + 2);  // with the one held and the one being decoded
}

TEST(CheckGroup, NamesTheFirstRoundThatDoesNotFit) {
  const auto trace = random_trace(8);
  const auto with_round = std::find_if(trace.groups.begin(), trace.groups.end(), [](const traces::RayGroup& g) {
    return !g.rays[0].rounds.empty() && !g.rays[0].processed.empty();
  });
  ASSERT_NE(with_round, trace.groups.end());
  const struct {
    const char* what;
    std::function<void(traces::RayGroup&)> damage;
  } cases[] = {
      {"pixel", [&](traces::RayGroup& g) { g.rays[0].pixel = trace.header.width * trace.header.height; }},
      {"k_count",
       [&](traces::RayGroup& g) { g.rays[0].rounds[0].k_count = static_cast<std::uint16_t>(trace.header.k + 1); }},
      {"preloaded", [](traces::RayGroup& g) { g.rays[0].rounds[0].preloaded = 60000; }},
      {"processed_count", [](traces::RayGroup& g) { g.rays[0].rounds[0].processed_count = 60000; }},
      {"events", [](traces::RayGroup& g) { g.rays[0].rounds[0].event_count += 1'000'000; }},
      {"processed", [](traces::RayGroup& g) { g.rays[0].processed.clear(); }},
      {"gaussian",
       [&](traces::RayGroup& g) {
         g.rays[0].processed[0].gaussian = static_cast<std::uint32_t>(trace.header.gaussians) & 0x7FFFFFFFU;
       }},
      {"rays", [](traces::RayGroup& g) { g.rays.resize(17); }}};
  EXPECT_NO_THROW(check_group(*with_round, trace.header, "a.grtx"));
  for (const auto& c : cases) {
    traces::RayGroup group = *with_round;
    c.damage(group);
    try {
      check_group(group, trace.header, "a.grtx");
      ADD_FAILURE() << c.what << " was accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.file(), "a.grtx");
      EXPECT_EQ(error.place().find("group " + std::to_string(group.index)), 0u) << error.place();
    }
  }
}

}  // namespace
}  // namespace grtx::sim
