// SPDX-License-Identifier: Apache-2.0
// Pops that repeat what was done last time are counted, 255 to a byte; only others take bytes of their own.
#include <gtest/gtest.h>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_codec.h"
#include "traces/random_group.h"

namespace grtx::traces {
namespace {

Event event_of(EventKind kind, std::uint32_t node, unsigned detail) {
  Event event;
  event.node = node;
  event.detail = static_cast<std::uint8_t>(detail);
  event.kind_shifts = Event::pack(kind);
  return event;
}

/// A root with two leaves at units 2 and 3. `restarts` rounds hit neither; one more, if told, hits the second.
RayGroup restarting_ray(unsigned restarts, bool last_hits) {
  RayGroup group;
  NodeDefinition root{
      .address = 1, .child_base = 2, .child_kinds = {NodeKind::triangle, NodeKind::triangle}, .child_count = 2};
  group.nodes = {root};
  Ray ray;
  Round round;
  round.event_count = 1;
  ray.rounds.assign(restarts, round);
  ray.events.assign(restarts, event_of(EventKind::visit_internal, 0, 0));
  if (last_hits) {
    round.event_count = 2;
    ray.rounds.push_back(round);
    ray.events.push_back(event_of(EventKind::visit_internal, 0, 0b10));
    ray.events.push_back(event_of(EventKind::visit_leaf, 3, static_cast<unsigned>(LeafOutcome::miss)));
  }
  group.rays = {ray};
  return group;
}

Header plain_header() {
  Header header = testing::random_trace({}).header;
  header.two_level = false;
  header.root = kNodeUnit;
  header.node_image_bytes = 10 * kNodeUnit;
  return header;
}

TEST(PredictedPops, AreCountedAtEveryLength) {
  const Header header = plain_header();
  struct Case {
    unsigned restarts;
    Bytes gaps;               ///< when nothing else follows
    Bytes gaps_before_other;  ///< when another pop follows
  };
  const Case cases[] = {{1, {1}, {1}},
                        {254, {254}, {254}},
                        {255, {255}, {255, 0}},
                        {256, {255, 1}, {255, 1}},
                        {510, {255, 255}, {255, 255, 0}},
                        {1000, {255, 255, 255, 235}, {255, 255, 255, 235}}};
  for (const Case& c : cases) {
    for (const bool other : {false, true}) {
      const RayGroup group = restarting_ray(c.restarts, other);
      Bytes payload;
      encode_group(header, group, payload);
      RayGroup decoded;
      decode_group(header, payload.data(), payload.size(), 0, decoded);
      EXPECT_EQ(decoded, group) << c.restarts;
      ColumnSet columns;
      unpack_columns(payload.data(), payload.size(), columns);
      EXPECT_EQ(columns[Column::inner_gap], other ? c.gaps_before_other : c.gaps) << c.restarts;
      EXPECT_EQ(columns[Column::inner], other ? Bytes{kPopHits} : Bytes{}) << c.restarts;
      EXPECT_EQ(columns[Column::hits], other ? Bytes{0b10} : Bytes{}) << c.restarts;
      EXPECT_EQ(columns[Column::leaf_gap], other ? Bytes{1} : Bytes{}) << c.restarts;  // a miss is expected at first
    }
  }
}

TEST(PredictedPops, GapsThatDoNotFitAreRefused) {
  const Header header = plain_header();
  const RayGroup group = restarting_ray(300, true);
  Bytes payload;
  encode_group(header, group, payload);
  ColumnSet sound;
  unpack_columns(payload.data(), payload.size(), sound);
  const auto decode = [&](const ColumnSet& columns) {
    Bytes packed;
    pack_columns(columns, packed);
    RayGroup decoded;
    decode_group(header, packed.data(), packed.size(), 0, decoded);
  };
  EXPECT_NO_THROW(decode(sound));
  struct Case {
    Column column;
    Bytes bytes;
  };
  const Case cases[] = {{Column::inner_gap, {255, 44}},      // one pop less: the byte of `inner` comes too early
                        {Column::inner_gap, {255, 46}},      // one more
                        {Column::inner_gap, {255, 45, 0}},   // a gap too many
                        {Column::inner, {0}},                // a pop that was predicted after all
                        {Column::inner, {kPopHits | 0x10}},  // a rank where there is no choice
                        {Column::inner, {kPopHits | 0x04}},  // an unknown operation
                        {Column::hits, {0}},                 // nothing changes
                        {Column::hits, {0b110}}};            // a child that is not there
  for (const Case& c : cases) {
    ColumnSet columns = sound;
    columns[c.column] = c.bytes;
    EXPECT_THROW(decode(columns), Malformed) << name_of(c.column) << " " << c.bytes.size();
  }
}

}  // namespace
}  // namespace grtx::traces
