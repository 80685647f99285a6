// SPDX-License-Identifier: Apache-2.0
// A file takes the oldest version that can say what its header says, and a reader knows both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/atomic_file.h"
#include "grtx/traces/byte_stream.h"
#include "grtx/traces/check.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/reader.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Case {
  ChildOrder child_order;
  PopTest pop_test;
  std::uint32_t version;
};
constexpr Case kCases[] = {{ChildOrder::near_first, PopTest::on, 4}, {ChildOrder::slot, PopTest::on, 4},
                           {ChildOrder::vulkan_sim, PopTest::on, 5}, {ChildOrder::near_first, PopTest::off, 5},
                           {ChildOrder::slot, PopTest::off, 5},      {ChildOrder::vulkan_sim, PopTest::off, 5}};

/// As the file says.
std::uint32_t version_of(const testing::TraceFile& file) {
  return load_u32(reinterpret_cast<const std::uint8_t*>(read_file(file.path()).data()) + 8);
}

TEST(Versions, AreTheOldestThatWillDo) {
  for (const Case& c : kCases) {
    testing::RandomOptions options{.child_order = c.child_order, .pop_test = c.pop_test};
    SCOPED_TRACE(testing::describe(options));
    const auto trace = testing::random_trace(options);
    const testing::TraceFile file(trace.header, trace.groups);
    EXPECT_EQ(version_of(file), c.version);
    const Reader reader(file.path());
    EXPECT_EQ(reader.header().child_order, c.child_order);
    EXPECT_EQ(reader.header().pop_test, c.pop_test);
    EXPECT_NO_THROW(check(reader, true));
  }
}

std::string fault_of(const std::string& json, std::uint32_t version) {
  try {
    header_from_json(json, version);
    return "";
  } catch (const Malformed& fault) {
    return fault.what();
  }
}

TEST(Versions, ASceneTlasNeedsTheSixth) {
  testing::RandomOptions options{.two_level = true};
  for (const unsigned objects : {0U, 2U}) {
    options.objects = objects;
    const auto trace = testing::random_trace(options);
    const testing::TraceFile file(trace.header, trace.groups);
    EXPECT_EQ(version_of(file), objects == 0 ? 4 : 6);
    const Reader reader(file.path());
    EXPECT_EQ(reader.header().object_roots, trace.header.object_roots);
    EXPECT_EQ(reader.header().scene_leaves, trace.header.scene_leaves);
    const std::string json = header_to_json(trace.header);
    const std::string unknown = objects == 0 ? "key 'pop_test' is missing" : "key 'object_roots' is unknown";
    EXPECT_THAT(fault_of(json, 5), HasSubstr(unknown));
  }
}

TEST(Versions, RefuseASceneTlasThatLeadsNowhere) {
  testing::RandomOptions options{.two_level = true, .objects = 2};
  const Header sound = testing::random_trace(options).header;
  const auto refusal = [&](auto&& damage) {
    Header header = sound;
    damage(header);
    return fault_of(header_to_json(header), 6);
  };
  EXPECT_EQ(refusal([](Header&) {}), "");
  EXPECT_THAT(refusal([](Header& h) { h.object_roots[0] += 1; }), HasSubstr("object_roots must be multiples of 64"));
  EXPECT_THAT(refusal([](Header& h) { h.object_roots[1] = h.object_roots[0]; }), HasSubstr("object_roots must ascend"));
  EXPECT_THAT(refusal([](Header& h) { h.object_roots[1] = h.blas_base; }), HasSubstr("object_roots must ascend"));
  EXPECT_THAT(refusal([](Header& h) { h.scene_leaves.clear(); }), HasSubstr("scene_leaves must be one or more"));
  EXPECT_THAT(refusal([](Header& h) { h.scene_leaves[0].object = 2; }), HasSubstr("must name one of object_roots"));
  EXPECT_THAT(refusal([](Header& h) { h.scene_leaves[0].address += 32; }), HasSubstr("scene_leaves must be multiples"));
  EXPECT_THAT(refusal([](Header& h) { h.scene_leaves.back().address = h.object_roots[0]; }),
              HasSubstr("scene_leaves must ascend"));
  std::string pairs = header_to_json(sound);
  pairs.replace(pairs.find("[["), 2, "[[7,");
  EXPECT_THAT(fault_of(pairs, 6), HasSubstr("key 'scene_leaves' must hold pairs"));
}

TEST(Versions, ASequenceOfFramesNeedsTheSeventh) {
  auto trace = testing::random_trace({});
  ASSERT_GE(trace.groups.size(), 3u);
  trace.header.frame_groups = {1, trace.groups.size() - 2, 1};
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 7u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().frame_groups, trace.header.frame_groups);
  EXPECT_NO_THROW(check(reader, true));
  RayGroup group;
  for (std::uint64_t i = 0; i < reader.group_count(); ++i) {
    reader.read(i, group);
    EXPECT_EQ(group.frame, i == 0 ? 0u : i + 1 < reader.group_count() ? 1u : 2u);
  }
  EXPECT_THAT(fault_of(header_to_json(trace.header), 6), HasSubstr("key 'frame_groups' is unknown"));
  for (const std::vector<std::uint64_t>& wrong :
       {std::vector<std::uint64_t>{trace.groups.size(), 0}, {1, trace.groups.size()}, {trace.groups.size() - 1}}) {
    Header header = trace.header;
    header.frame_groups = wrong;
    EXPECT_THAT(fault_of(header_to_json(header), 7), HasSubstr("frame_groups must be at least 1 each and add up"));
  }
}

TEST(Versions, StructuresOfBoxesNeedTheEighth) {
  for (const AccelKind kind : {AccelKind::box, AccelKind::tlas_box}) {
    testing::RandomOptions options{.two_level = is_two_level(kind)};
    auto trace = testing::random_trace(options);
    trace.header.accel = kind;
    for (RayGroup& group : trace.groups) {
      for (NodeDefinition& node : group.nodes) {
        for (NodeKind& child : node.child_kinds) {
          if (child == NodeKind::triangle) child = NodeKind::procedural;
        }
      }
    }
    const testing::TraceFile file(trace.header, trace.groups);
    EXPECT_EQ(version_of(file), 8u);
    const Reader reader(file.path());
    EXPECT_EQ(reader.header().accel, kind);
    EXPECT_NO_THROW(check(reader, true));
    EXPECT_THAT(fault_of(header_to_json(trace.header), 7),
                HasSubstr("key 'accel' holds a value that version 7 does not have"));
  }
}

TEST(Versions, WideLeavesNeedTheThirteenth) {
  testing::RandomOptions options{.layout = NodeLayout::quantised, .two_level = true};
  const auto narrow = testing::random_trace(options);
  EXPECT_EQ(version_of(testing::TraceFile(narrow.header, narrow.groups)), 4u);
  EXPECT_EQ(header_to_json(narrow.header).find("wide_leaves"), std::string::npos);
  options.wide = true;
  auto trace = testing::random_trace(options);
  ASSERT_GT(trace.header.wide_leaves, 0u);
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 13u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().wide_leaves, trace.header.wide_leaves);
  EXPECT_NO_THROW(check(reader, true));
  EXPECT_THAT(fault_of(header_to_json(trace.header), 12), HasSubstr("key 'wide_leaves' is unknown"));
  trace.header.layout = NodeLayout::vulkan_sim;
  EXPECT_THAT(header_fault(trace.header), HasSubstr("wide_leaves must be at most gaussians, and 0 unless"));
}

TEST(Versions, ListsNeedTheTenth) {
  testing::RandomOptions options{.k = 5, .checkpoint = false, .tracing = Tracing::list};
  const auto trace = testing::random_trace(options);
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 10u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().tracing, Tracing::list);
  EXPECT_EQ(reader.header().k, 5u);
  EXPECT_NO_THROW(check(reader, true));
  EXPECT_THAT(fault_of(header_to_json(trace.header), 9),
              HasSubstr("key 'tracing' holds a value that version 9 does not have"));
}

TEST(Versions, DelayedAnyHitShadersAndATestOnceARoundNeedTheEleventh) {
  for (const auto& [any_hit, ert_check] : {std::pair(AnyHit::delayed, ErtCheck::hit),
                                           {AnyHit::immediate, ErtCheck::round},
                                           {AnyHit::delayed, ErtCheck::round}}) {
    testing::RandomOptions options{.checkpoint = false, .any_hit = any_hit, .ert_check = ert_check};
    const auto trace = testing::random_trace(options);
    const testing::TraceFile file(trace.header, trace.groups);
    EXPECT_EQ(version_of(file), 11u);
    const Reader reader(file.path());
    EXPECT_EQ(reader.header().any_hit, any_hit);
    EXPECT_EQ(reader.header().ert_check, ert_check);
    EXPECT_NO_THROW(check(reader, true));
    EXPECT_THAT(fault_of(header_to_json(trace.header), 10), HasSubstr("key 'any_hit' is unknown"));
  }
  Header header;
  header.pop_test = PopTest::off;
  EXPECT_THAT(fault_of(header_to_json(header), 11), HasSubstr("is missing"));
}

TEST(Versions, NodesUnderWayAtOnceNeedTheTwelfth) {
  auto trace = testing::random_trace({.checkpoint = false});
  trace.header.ahead = 8;
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 12u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().ahead, 8u);
  EXPECT_NO_THROW(check(reader, true));
  EXPECT_THAT(fault_of(header_to_json(trace.header), 11), HasSubstr("key 'ahead' is unknown"));
  const auto fault = [](auto&& set) {
    Header header;
    header.ahead = 2;
    set(header);
    return header_fault(header);
  };
  EXPECT_EQ(fault([](Header&) {}), "");
  const auto rule = HasSubstr("ahead must be 1 unless tracing is multi");
  EXPECT_THAT(fault([](Header& h) { h.two_level = true; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.tracing = Tracing::single; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.any_hit = AnyHit::delayed; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.checkpoint = true, h.checkpoint_capacity = 8; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.ahead = 33; }), HasSubstr("ahead must be 1..32"));
}

TEST(Versions, TheBoundByOpacityNeedsTheFourteenth) {
  auto trace = testing::random_trace({.checkpoint = false});
  trace.header.opacity_bound = OpacityBound::on;
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 14u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().opacity_bound, OpacityBound::on);
  EXPECT_NO_THROW(check(reader, true)) << "nothing is hidden";
  EXPECT_THAT(fault_of(header_to_json(trace.header), 13), HasSubstr("key 'opacity_bound' is unknown"));
  const auto fault = [](auto&& set) {
    Header header;
    header.opacity_bound = OpacityBound::on;
    set(header);
    return header_fault(header);
  };
  EXPECT_EQ(fault([](Header& h) { h.ahead = 4; }), "");
  const auto rule = HasSubstr("opacity_bound must be off unless tracing is multi");
  EXPECT_THAT(fault([](Header& h) { h.tracing = Tracing::list; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.tracing = Tracing::closest, h.k = 1; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.any_hit = AnyHit::delayed; }), rule);
  EXPECT_THAT(fault([](Header& h) { h.ert_check = ErtCheck::round; }), rule);
}

TEST(Versions, ColoursOnceInAFrameNeedTheSixteenth) {
  auto trace = testing::random_trace({.colour = ColourPer::frame});
  const testing::TraceFile file(trace.header, trace.groups);
  EXPECT_EQ(version_of(file), 16u);
  const Reader reader(file.path());
  EXPECT_EQ(reader.header().colour, ColourPer::frame);
  EXPECT_NO_THROW(check(reader, true));
  EXPECT_THAT(fault_of(header_to_json(trace.header), 14), HasSubstr("key 'colour' is unknown"));
  Header objects = trace.header;
  objects.two_level = true;
  objects.object_roots = {64};
  EXPECT_THAT(header_fault(objects), HasSubstr("colour must be hit when there are object_roots"));
}

TEST(Versions, SecondaryRaysThatTakeTheCamerasColoursAreFound) {
  auto trace = testing::random_trace({.colour = ColourPer::frame});
  trace.groups.back().kind = static_cast<RayKind>(1);
  const testing::TraceFile file(trace.header, trace.groups);
  const Reader reader(file.path());
  EXPECT_THAT([&] { check(reader, true); }, ::testing::ThrowsMessage<Error>(HasSubstr("are for rays from the camera")));
}

TEST(Versions, RefuseModesThatDoNotGoTogether) {
  const auto fault = [](auto&& set) {
    Header header;
    set(header);
    return header_fault(header);
  };
  const auto delayed = HasSubstr("any_hit may be delayed only when tracing is multi and checkpoint is false");
  const auto by_round = HasSubstr("ert_check must be hit when tracing is list");
  EXPECT_EQ(fault([](Header& h) { h.any_hit = AnyHit::delayed; }), "");
  EXPECT_EQ(fault([](Header& h) { h.ert_check = ErtCheck::round; }), "");
  for (const Tracing tracing : {Tracing::single, Tracing::closest, Tracing::list}) {
    const auto with = [tracing](Header& h) {
      h.tracing = tracing;
      h.k = 1;
    };
    EXPECT_THAT(fault([&](Header& h) { with(h), h.any_hit = AnyHit::delayed; }), delayed);
    const std::string once_a_round = fault([&](Header& h) { with(h), h.ert_check = ErtCheck::round; });
    if (tracing == Tracing::list) {
      EXPECT_THAT(once_a_round, by_round);
    } else {
      EXPECT_EQ(once_a_round, "");
    }
  }
  EXPECT_THAT(fault([](Header& h) {
                h.checkpoint = true;
                h.checkpoint_capacity = 8;
                h.any_hit = AnyHit::delayed;
              }),
              delayed);
}

TEST(Versions, HaveTheirOwnKeys) {
  Header header;
  const std::string four = header_to_json(header);
  EXPECT_THAT(four, Not(HasSubstr("pop_test")));
  EXPECT_EQ(fault_of(four, 4), "");
  EXPECT_THAT(fault_of(four, 5), HasSubstr("key 'pop_test' is missing"));
  header.pop_test = PopTest::off;
  const std::string five = header_to_json(header);
  EXPECT_EQ(fault_of(five, 5), "");
  EXPECT_THAT(fault_of(five, 4), HasSubstr("key 'pop_test' is unknown"));
  std::string vulkan_sim = four;
  vulkan_sim.replace(vulkan_sim.find("near_first"), 10, "vulkan_sim");
  EXPECT_THAT(fault_of(vulkan_sim, 4), HasSubstr("key 'child_order' holds a value that version 4 does not have"));
}

}  // namespace
}  // namespace grtx::traces
