// SPDX-License-Identifier: Apache-2.0
// decode_group on damaged columns: refuses or yields a group that encodes again; never crashes, never takes much
// memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/decoded_size.h"
#include "limited_memory.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/random_group.h"

namespace grtx::traces {
namespace {

using testing::RandomOptions;

void damage(Bytes& column, std::mt19937& random) {
  if (column.empty() || random() % 8 == 0) {
    column.push_back(static_cast<std::uint8_t>(random()));
    return;
  }
  const auto at = static_cast<std::ptrdiff_t>(random() % column.size());
  switch (random() % 3) {
    case 0:
      column[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(random());
      break;
    case 1:
      column.erase(column.begin() + at);
      break;
    default:
      column[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << random() % 8);
      break;
  }
}

TEST(DecoderFuzz, DamagedColumns) {
  std::mt19937 random(7);
  std::uint64_t refused = 0;
  std::uint64_t accepted = 0;
  for (const RandomOptions& options : testing::all_random_options()) {
    const auto trace = testing::random_trace(options);
    const RayGroup& group = trace.groups[0];
    Bytes payload;
    encode_group(trace.header, group, payload);
    ColumnSet columns;
    const std::size_t count = options.bins != 0 ? kColumnCount : kColumnsWithoutBins;
    unpack_columns(payload.data(), payload.size(), columns, count);
    for (int i = 0; i < 60; ++i) {
      ColumnSet damaged = columns;
      const auto hits = 1 + random() % 3;
      for (std::size_t h = 0; h < hits; ++h) damage(damaged[static_cast<Column>(random() % count)], random);
      Bytes packed;
      pack_columns(damaged, packed, count);
      RayGroup decoded;
      try {
        decode_group(trace.header, packed.data(), packed.size(), 0, decoded);
      } catch (const Malformed&) {
        ++refused;
        continue;
      }
      ++accepted;
      std::size_t events = 0;
      for (const Ray& ray : decoded.rays) events += ray.events.size();
      EXPECT_LE(events, 2 * kLongGap * damaged.bytes());  // a byte stands for so many predicted pops
      Bytes again;
      EXPECT_NO_THROW(encode_group(trace.header, decoded, again)) << testing::describe(options);
      RayGroup twice;
      decode_group(trace.header, again.data(), again.size(), 0, twice);
      EXPECT_EQ(twice, decoded);
    }
  }
  EXPECT_GT(refused, 1000U);
  EXPECT_GT(accepted, 100U);
}

TEST(DecoderFuzz, RandomBytes) {
  std::mt19937 random(8);
  const auto trace = testing::random_trace(RandomOptions{});
  for (int i = 0; i < 3000; ++i) {
    Bytes payload(random() % 200);
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random() % (i % 2 == 0 ? 256 : 4));
    RayGroup decoded;
    EXPECT_THROW(decode_group(trace.header, payload.data(), payload.size(), 0, decoded), Malformed);
  }
}

// Twenty stored bytes cannot stand for a GiB, so none is allocated.
TEST(DecoderFuzz, AbsurdSizesAreRefusedBeforeAllocation) {
  for (const std::uint64_t claimed : {kMaxGroupBytes, kMaxGroupBytes + 1, std::uint64_t{1} << 60}) {
    for (const std::uint64_t stored : {0U, 20U}) {
      Bytes payload;
      for (std::size_t i = 0; i < kColumnsWithoutBins; ++i) {
        put_varint(payload, i == 3 ? claimed : 0);
        put_varint(payload, i == 3 ? stored : 0);
      }
      payload.resize(payload.size() + 20);
      ColumnSet columns;
      EXPECT_THROW(unpack_columns(payload.data(), payload.size(), columns), Malformed);
      EXPECT_EQ(columns.bytes(), 0U);
    }
  }
}

// A byte of a chunk may stand for a million events.
TEST(DecoderFuzz, AGroupLargerThanTheMemoryIsRefusedWithItsSize) {
  const sim::test::TinyTrace tiny{1, 32};
  RayGroup group = sim::test::tiny_group(tiny, 0);
  for (Ray& ray : group.rays) {
    ray.rounds.front().k_count = ray.rounds.front().processed_count = 0;
    ray.processed.clear();
    const std::vector<Event> events = ray.events;
    for (int i = 1; i < 50'000; ++i) {
      ray.rounds.push_back(ray.rounds.front());
      ray.events.insert(ray.events.end(), events.begin(), events.end());
    }
  }
  Bytes payload;
  encode_group(sim::test::tiny_header(tiny), group, payload);
  ASSERT_LT(100 * payload.size(), decoded_bytes(group));
  const auto decode = [&](std::uint64_t left) {
    const grtx::test::LimitedMemory limit(left);
    RayGroup decoded;
    decode_group(sim::test::tiny_header(tiny), payload.data(), payload.size(), 0, decoded);
    return decoded == group;
  };
  EXPECT_TRUE(decode(4 * decoded_bytes(group)));
  try {
    decode(decoded_bytes(group) / 2);
    ADD_FAILURE() << "was decoded";
  } catch (const Malformed& fault) {
    EXPECT_THAT(fault.what(), ::testing::MatchesRegex("takes .* MB more memory, and .* MB are free, to be decoded"));
  }
}

}  // namespace
}  // namespace grtx::traces
