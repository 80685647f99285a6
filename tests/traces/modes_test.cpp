// The modes in a trace's header: each name stands for one value, as trace files have always spelt it.
#include "grtx/traces/modes.h"

#include <gtest/gtest.h>

#include <set>

namespace grtx::traces {
namespace {

template <NamedEnum Enum>
void expect_names(const std::vector<std::string>& expected) {
  EXPECT_EQ(names_of<Enum>(), expected);
  std::set<Enum> values;
  for (const std::string& name : expected) {
    const auto value = from_name<Enum>(name);
    ASSERT_TRUE(value.has_value()) << name;
    EXPECT_EQ(name_of(*value), name);
    EXPECT_TRUE(values.insert(*value).second) << name;
  }
}

TEST(Modes, AreSpeltAsInTraceFiles) {
  expect_names<AccelKind>(
      {"tri20", "tri80", "ellipsoid", "box", "tlas-tri20", "tlas-tri80", "tlas-sphere", "tlas-box"});
  expect_names<Tracing>({"multi", "single", "closest", "stochastic", "list"});
  expect_names<CheckpointOrder>({"fifo", "lifo", "nearest"});
  expect_names<ChildOrder>({"near_first", "slot", "vulkan_sim"});
  expect_names<PopTest>({"on", "off"});
  expect_names<WarpMapping>({"tile8x4", "linear"});
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
