// SPDX-License-Identifier: Apache-2.0
// The modes in a trace's header: each name stands for one value, as trace files have always spelt it.
#include "grtx/traces/modes.h"

#include <gtest/gtest.h>

#include <set>

namespace grtx::traces {
namespace {

template <NamedEnum Enum>
void expect_spelling(const std::vector<std::string>& expected) {
  EXPECT_EQ(names_of<Enum>(), expected);
  std::set<Enum> values;
  for (const std::string& name : expected) {
    const auto value = from_name<Enum>(name);
    ASSERT_TRUE(value.has_value()) << name;
    EXPECT_EQ(grtx::name_of(*value), name);
    EXPECT_TRUE(values.insert(*value).second) << name;
  }
}

TEST(Modes, AreSpeltAsInTraceFiles) {
  expect_spelling<AccelKind>(
      {"tri20", "tri80", "ellipsoid", "box", "tlas-tri20", "tlas-tri80", "tlas-sphere", "tlas-box"});
  expect_spelling<Tracing>({"multi", "single", "closest", "list"});
  expect_spelling<CheckpointOrder>({"fifo", "lifo", "nearest"});
  expect_spelling<ChildOrder>({"near_first", "slot", "vulkan_sim"});
  expect_spelling<PopTest>({"on", "off"});
  expect_spelling<AnyHit>({"immediate", "delayed"});
  expect_spelling<ErtCheck>({"hit", "round"});
  expect_spelling<WarpMapping>({"tile8x4", "linear"});
}

TEST(Modes, StructuresOfSpheresAndBoxesHaveProceduralLeaves) {
  for (const std::string& name : names_of<AccelKind>()) {
    const AccelKind kind = *from_name<AccelKind>(name);
    EXPECT_EQ(is_two_level(kind), name.starts_with("tlas-")) << name;
    const bool box = name == "box" || name == "tlas-box";
    EXPECT_EQ(has_box_leaves(kind), box) << name;
    EXPECT_EQ(has_procedural_leaves(kind), box || name == "ellipsoid" || name == "tlas-sphere") << name;
  }
}

}  // namespace
}  // namespace grtx::traces
