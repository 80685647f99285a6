// SPDX-License-Identifier: Apache-2.0
// What is written is read back, field by field, for every kind of trace.
#include <gtest/gtest.h>

#include "grtx/traces/check.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/reader.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using testing::RandomOptions;

void expect_round_trip(const RandomOptions& options) {
  SCOPED_TRACE(testing::describe(options));
  const auto trace = testing::random_trace(options);
  const testing::TraceFile file(trace.header, trace.groups);
  const Reader reader(file.path());
  EXPECT_EQ(header_to_json(reader.header()), header_to_json(trace.header));
  ASSERT_EQ(reader.group_count(), trace.groups.size());
  RayGroup group;  // reused, as a simulator would
  for (std::size_t i = trace.groups.size(); i-- > 0;) {
    reader.read(i, group);
    EXPECT_EQ(group, trace.groups[i]);
  }
  EXPECT_NO_THROW(check(reader, true));
}

TEST(RoundTrip, EveryCombinationOfOptions) {
  for (const RandomOptions& options : testing::all_random_options()) expect_round_trip(options);
}

TEST(RoundTrip, SingleRoundWithALargeKBuffer) {
  RandomOptions options{.groups = 1, .depth = 5, .k = 2048, .checkpoint = false, .tracing = Tracing::single};
  expect_round_trip(options);
  options.tracing = Tracing::list;
  expect_round_trip(options);
}

TEST(RoundTrip, NodesOfOtherLayoutsOfEveryKindOfTrace) {
  for (const NodeLayout layout : {NodeLayout::compact, NodeLayout::compressed, NodeLayout::quantised}) {
    for (const bool two_level : {false, true}) {
      for (const bool checkpoint : {false, true}) {
        for (const unsigned width : {2U, 6U, 8U}) {
          if (layout == NodeLayout::quantised && width > kQuantisedWidth) continue;
          RandomOptions options{.bvh_width = width,
                                .layout = layout,
                                .checkpoint = checkpoint,
                                .capacity = checkpoint ? 12u : 0u,
                                .two_level = two_level};
          expect_round_trip(options);
          if (layout != NodeLayout::quantised) continue;
          for (const bool procedural : {false, true}) {
            options.procedural = procedural;
            options.wide = two_level || procedural;
            options.seed += 3;
            expect_round_trip(options);
          }
        }
      }
    }
  }
}

// So that traces of the default layout are what they were, to the byte.
TEST(RoundTrip, TheDefaultLayoutIsNotWritten) {
  Header header;
  header.node_image_bytes = 64;
  EXPECT_EQ(header_to_json(header).find("layout"), std::string::npos);
  EXPECT_EQ(header_from_json(header_to_json(header), format_version(header)).layout, NodeLayout::vulkan_sim);
  header.layout = NodeLayout::compact;
  header.node_image_bytes = 800;
  header.root = 64;
  EXPECT_EQ(header_fault(header), "root, blas_base and blas_root must be multiples of 80");
  header.root = 80;
  EXPECT_EQ(header_from_json(header_to_json(header), format_version(header)).layout, NodeLayout::compact);
}

TEST(RoundTrip, NoGroups) {
  RandomOptions options{.groups = 0};
  expect_round_trip(options);
}

TEST(RoundTrip, RaysThatMeetNothing) {
  RandomOptions options;
  auto trace = testing::random_trace(options);
  for (RayGroup& group : trace.groups) {
    group.nodes.clear();
    group.rays.assign(3, Ray{});
  }
  const testing::TraceFile file(trace.header, trace.groups);
  const Reader reader(file.path());
  RayGroup group;
  reader.read(1, group);
  EXPECT_EQ(group, trace.groups[1]);
  EXPECT_EQ(check(reader, true).rays, 9U);
}

TEST(RoundTrip, RandomTracesCoverEveryEventAndOutcome) {
  std::set<std::string> seen;
  Totals sum;
  for (const RandomOptions& options : testing::all_random_options()) {
    for (const RayGroup& group : testing::random_trace(options).groups) {
      for (const Ray& ray : group.rays) {
        for (const Event& e : ray.events) {
          const bool leaf_or_instance = e.kind() == EventKind::visit_leaf || e.kind() == EventKind::visit_instance;
          seen.insert(std::to_string(static_cast<int>(e.kind())) + "/" +
                      (leaf_or_instance ? std::to_string(e.detail) : "") + "/" + (e.checkpoints != 0 ? "c" : "-"));
        }
        for (const Round& round : ray.rounds) sum.overflows += round.overflow ? 1 : 0;
      }
    }
  }
  // internal x2, instance x2, leaf 8 + beyond checkpointed, cull x2, take, forward x2
  EXPECT_EQ(seen.size(), 2U + 2U + 9U + 2U + 1U + 2U) << ::testing::PrintToString(seen);
  EXPECT_GT(sum.overflows, 0U);
}

TEST(RoundTrip, EveryHeaderFieldIsKept) {
  Header header;
  header.accel = AccelKind::tlas_sphere;
  header.k = 17;
  header.checkpoint = true;
  header.checkpoint_order = CheckpointOrder::nearest;
  header.child_order = ChildOrder::slot;
  header.pop_test = PopTest::off;
  header.width = 1557;
  header.height = 1038;
  header.warp_size = 64;
  header.warp_mapping = WarpMapping::linear;
  header.groups = 7;
  header.bvh_width = 8;
  header.node_image_bytes = 1ULL << 33;
  header.root = 64;
  header.two_level = true;
  header.blas_base = 1ULL << 32;
  header.blas_root = (1ULL << 32) + 64;
  header.blas_bytes = 640;
  header.blas_root_is_leaf = true;
  header.gaussians = 3000000;
  header.sh_degree = 2;
  header.gaussian_record_bytes = 64;
  header.sh_record_bytes = 108;
  header.checkpoint_capacity = 99;
  header.inputs = {{"scene", "a\nb"}, {"", "empty name"}};
  const Header back = header_from_json(header_to_json(header), format_version(header));
  EXPECT_EQ(header_to_json(back), header_to_json(header));
  EXPECT_EQ(back.accel, header.accel);
  EXPECT_EQ(back.checkpoint, header.checkpoint);
  EXPECT_EQ(back.checkpoint_order, header.checkpoint_order);
  EXPECT_EQ(back.child_order, header.child_order);
  EXPECT_EQ(back.pop_test, header.pop_test);
  EXPECT_EQ(back.warp_mapping, header.warp_mapping);
  EXPECT_EQ(back.node_image_bytes, header.node_image_bytes);
  EXPECT_EQ(back.blas_root, header.blas_root);
  EXPECT_EQ(back.blas_bytes, header.blas_bytes);
  EXPECT_EQ(back.sh_record_bytes, header.sh_record_bytes);
  EXPECT_EQ(back.inputs, header.inputs);
}

TEST(RoundTrip, ClaimsThatNoMachineCouldHoldAreRefused) {
  const auto refusal = [](auto&& damage) {
    Header header;
    damage(header);
    return header_fault(header);
  };
  EXPECT_EQ(refusal([](Header&) {}), "");
  EXPECT_EQ(refusal([](Header& h) { h.node_image_bytes = 1ULL << 38; }),
            "node image and records must take at most 64 GiB");
  EXPECT_EQ(refusal([](Header& h) { h.gaussians = 1ULL << 31; }), "node image and records must take at most 64 GiB");
  EXPECT_EQ(refusal([](Header& h) { h.sh_record_bytes = ~0ULL; }),
            "sh_record_bytes must be what layout and sh_degree, which is at most 4, give");
  EXPECT_EQ(refusal([](Header& h) { h.sh_degree = 1; }),
            "sh_record_bytes must be what layout and sh_degree, which is at most 4, give");
  EXPECT_EQ(refusal([](Header& h) {
              h.sh_degree = ~0U;
              h.sh_record_bytes = 0;
            }),
            "sh_record_bytes must be what layout and sh_degree, which is at most 4, give");
  EXPECT_EQ(refusal([](Header& h) { h.gaussian_record_bytes = 1ULL << 32; }),
            "gaussian_record_bytes must be a multiple of 16 and at most 256");
  EXPECT_EQ(refusal([](Header& h) {
              h.two_level = true;
              h.accel = AccelKind::tlas_tri20;
              h.node_image_bytes = 4096;
              h.blas_base = 0;
            }),
            "blas_root must lie behind blas_base, which must not be 0, when two_level");
  EXPECT_EQ(refusal([](Header& h) { h.width = h.height = 1U << 16; }), "width and height must be at most 2^28 pixels");
  EXPECT_EQ(refusal([](Header& h) {
              h.checkpoint = true;
              h.checkpoint_capacity = 1ULL << 40;
            }),
            "checkpoint_capacity must be at most 2^24");
  EXPECT_EQ(refusal([](Header& h) {  // aborted in the memory map
              h.checkpoint = true;
              h.checkpoint_capacity = 0;
            }),
            "checkpoint_capacity must be above 0 when checkpoint is true");
}

/// A chain of nodes, each with a leaf that stays on the stack while the next node is visited.
TEST(RoundTrip, AStackOfHundredsOfEntriesIsKept) {
  constexpr std::uint32_t kNodes = 500;
  Header header;
  header.k = 1;
  header.width = header.height = 8;
  header.groups = 1;
  header.root = kNodeUnit;
  header.node_image_bytes = (2 * kNodes + 2) * kNodeUnit;
  header.gaussians = 10;
  RayGroup group;
  group.rays.resize(1);
  Ray& ray = group.rays[0];
  for (std::uint32_t i = 0; i < kNodes; ++i) {
    const NodeKind second = i + 1 < kNodes ? NodeKind::internal : NodeKind::triangle;
    group.nodes.push_back({i == 0 ? 1 : 2 * i + 1, 2 * i + 2, {NodeKind::triangle, second}, 2});
    ray.events.push_back({i, 0b11, 0, Event::pack(EventKind::visit_internal)});
  }
  const auto miss = static_cast<std::uint8_t>(LeafOutcome::miss);
  ray.events.push_back({2 * kNodes + 1, miss, 0, Event::pack(EventKind::visit_leaf)});
  for (std::uint32_t i = kNodes; i-- > 0;) {
    ray.events.push_back({2 * i + 2, miss, 0, Event::pack(EventKind::visit_leaf)});
  }
  Round round;
  round.event_count = static_cast<std::uint32_t>(ray.events.size());
  ray.rounds = {round};
  const testing::TraceFile file(header, {group});
  const Reader reader(file.path());
  EXPECT_NO_THROW(check(reader, true));
  RayGroup found;
  reader.read(0, found);
  EXPECT_EQ(found.rays[0].events, ray.events);
  EXPECT_EQ(found.nodes, group.nodes);
}

}  // namespace
}  // namespace grtx::traces
